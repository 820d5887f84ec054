//! Names of topics as they are in the graph.

use crate::base::Result;
use crate::config::Config;
use crate::live::node::NodeOptions;

/// The parameters with the full names of all topics: a name without a slash in front is one of the node's namespace.
pub(super) fn with_full_names(options: &NodeOptions) -> Result<Config> {
    let full = |name: &str| if name.is_empty() { Ok(String::new()) } else { options.naming.expand(name) };
    let expand = |config: &mut Config| -> Result<()> {
        for name in [
            &mut config.depth_topic,
            &mut config.depth_info_topic,
            &mut config.color_topic,
            &mut config.color_info_topic,
            &mut config.confidence_topic,
            &mut config.odometry_topic,
            &mut config.scan_topic,
            &mut config.goal_topic,
        ] {
            *name = full(name)?;
        }
        Ok(())
    };
    let mut config = options.config.clone();
    expand(&mut config)?;
    config.sensors.iter_mut().try_for_each(|sensor| expand(&mut sensor.parameters))?;
    Ok(config)
}
