//! Names of nodes and topics as ROS 2 has them: `~`, namespaces, remappings; and as DDS has them.

use crate::base::Result;
use crate::ros2::ros2_error;

/// A node's name and what its topics are called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Naming {
    node: String,
    /// With a leading slash; `/` alone at the root.
    namespace: String,
    /// From and to, expanded.
    remaps: Vec<(String, String)>,
}

impl Naming {
    /// A node in a namespace, with remappings of topics and services (`from`, `to`).
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] for names that ROS 2 does not allow.
    pub fn new(node: &str, namespace: &str, remaps: &[(String, String)]) -> Result<Self> {
        check_part(node, "node name", node)?;
        let namespace = format!("/{}", namespace.trim_matches('/'));
        if namespace.len() > 1 {
            check_topic(&namespace, "namespace")?;
        }
        let mut naming = Self { node: node.into(), namespace, remaps: Vec::new() };
        for (from, to) in remaps {
            let pair = (naming.expand(from)?, naming.expand(to)?);
            naming.remaps.push(pair);
        }
        Ok(naming)
    }

    /// The node's own name.
    pub fn node(&self) -> &str {
        &self.node
    }

    /// Its namespace, with a leading slash.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Namespace and name.
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.namespace.trim_end_matches('/'), self.node)
    }

    /// The full name of a topic or service, remapped: `/a` as it is, `~/a` under the node, `a` in the namespace.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] for names that ROS 2 does not allow.
    pub fn resolve(&self, name: &str) -> Result<String> {
        let full = self.expand(name)?;
        let remapped = self.remaps.iter().find(|(from, _)| *from == full);
        Ok(remapped.map_or(full, |(_, to)| to.clone()))
    }

    /// What a topic of the graph is called without remappings; `None` where its name is another topic's by a remapping.
    pub fn present<'a>(&'a self, full: &'a str) -> Option<&'a str> {
        let own = self.remaps.iter().find(|(_, to)| to == full).map(|(from, _)| from.as_str());
        own.or_else(|| (!self.remaps.iter().any(|(from, _)| from == full)).then_some(full))
    }

    /// The full name of a topic or service, without remappings.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] for names that ROS 2 does not allow.
    pub fn expand(&self, name: &str) -> Result<String> {
        let full = match (name.strip_prefix("~/"), name.starts_with('/')) {
            (Some(own), _) => format!("{}/{own}", self.full_name()),
            (None, true) => name.to_owned(),
            (None, false) => format!("{}/{name}", self.namespace.trim_end_matches('/')),
        };
        check_topic(&full, "name")?;
        Ok(full)
    }
}

/// Whether an absolute name is one of ROS 2's: parts of letters, digits and `_`, none empty, none with a digit first.
fn check_topic(full: &str, what: &str) -> Result<()> {
    full.trim_start_matches('/').split('/').try_for_each(|part| check_part(part, what, full))
}

fn check_part(part: &str, what: &str, full: &str) -> Result<()> {
    let letters = part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if letters && part.starts_with(|c: char| !c.is_ascii_digit()) {
        return Ok(());
    }
    Err(ros2_error(
        format!("{what} `{full}`"),
        "is not letters, digits and `_` between slashes, each part beginning with no digit",
    ))
}

/// DDS name of a topic.
pub(super) fn dds_topic(full: &str) -> String {
    format!("rt{full}")
}

/// Full name of a DDS topic, where it is a topic of ROS 2.
pub(super) fn topic_of_dds(dds: &str) -> Option<&str> {
    dds.strip_prefix("rt").filter(|name| name.starts_with('/'))
}

/// DDS name of a type such as `sensor_msgs/msg/Image`; `None` where it is no such name.
pub(super) fn dds_type(ros: &str) -> Option<String> {
    match ros.split('/').collect::<Vec<_>>()[..] {
        [package, "msg", name] => Some(format!("{package}::msg::dds_::{name}_")),
        _ => None,
    }
}

/// Type such as `sensor_msgs/msg/Image` of its DDS name; other names as they are.
pub fn type_of_dds(dds: &str) -> String {
    let parts = dds.split("::").collect::<Vec<_>>();
    match (&parts[..], dds.strip_suffix('_')) {
        ([package, kind, "dds_", _], Some(bare)) => {
            format!("{package}/{kind}/{}", bare.rsplit("::").next().unwrap_or_default())
        }
        _ => dds.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn naming(node: &str, namespace: &str, remaps: &[(&str, &str)]) -> Result<Naming> {
        let remaps: Vec<_> = remaps.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect();
        Naming::new(node, namespace, &remaps)
    }

    #[test]
    fn names_expand_as_ros_2_expands_them() {
        let naming =
            naming("limpid", "/robot1/", &[("~/costmap", "/map"), ("points", "lidar/points")]).unwrap();
        assert_eq!(naming.full_name(), "/robot1/limpid");
        let resolved = |name: &str| naming.resolve(name).unwrap();
        assert_eq!(resolved("/tf"), "/tf");
        assert_eq!(resolved("tf"), "/robot1/tf");
        assert_eq!(resolved("~/why"), "/robot1/limpid/why");
        assert_eq!(resolved("~/costmap"), "/map");
        assert_eq!(resolved("points"), "/robot1/lidar/points");
    }

    #[test]
    fn topics_of_the_graph_are_found_under_the_names_that_are_remapped() {
        let naming = naming("limpid", "/robot1", &[("/tf", "tf"), ("/points", "/top/points")]).unwrap();
        assert_eq!(naming.present("/robot1/tf"), Some("/tf"));
        assert_eq!(naming.present("/tf"), None, "that of another robot");
        assert_eq!(naming.present("/top/points"), Some("/points"));
        assert_eq!(naming.present("/depth"), Some("/depth"));
        for presented in ["/tf", "/points", "/depth"] {
            let full = naming.resolve(presented).unwrap();
            assert_eq!(naming.present(&full), Some(presented));
        }
    }

    #[test]
    fn names_that_ros_2_refuses_are_refused() {
        for bad in ["a b", "/a//b", "/1a", "/a/", "~/é", ""] {
            assert!(naming("limpid", "", &[]).unwrap().resolve(bad).is_err(), "{bad}");
        }
        assert!(naming("lim/pid", "", &[]).is_err() && naming("limpid", "/a b", &[]).is_err());
    }

    #[test]
    fn dds_names_are_there_and_back() {
        assert_eq!(topic_of_dds(&dds_topic("/a/b")), Some("/a/b"));
        assert_eq!(topic_of_dds("rq/a/bRequest"), None);
        let dds = dds_type("sensor_msgs/msg/Image").unwrap();
        assert_eq!(dds, "sensor_msgs::msg::dds_::Image_");
        assert_eq!(type_of_dds(&dds), "sensor_msgs/msg/Image");
        assert_eq!((type_of_dds("Shape"), dds_type("Shape")), ("Shape".into(), None));
    }
}
