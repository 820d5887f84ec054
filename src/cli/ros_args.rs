//! `--ros-args`, as every ROS 2 node takes them: node name, namespace, remappings, parameters.

use std::path::PathBuf;

use limpid::ros2::Naming;
use limpid::{Error, Result};

/// What stands between `--ros-args` and `--` or the end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct RosArgs {
    /// `-r __node:=NAME`.
    node: Option<String>,
    /// `-r __ns:=NAMESPACE`.
    namespace: Option<String>,
    /// `-r FROM:=TO`.
    remaps: Vec<(String, String)>,
    /// `-p KEY:=VALUE`, the value as YAML.
    pub(crate) parameters: Vec<(String, String)>,
    /// `--params-file FILE`.
    pub(crate) files: Vec<PathBuf>,
    /// What is taken and does nothing here.
    pub(crate) notes: Vec<String>,
}

fn bad(argument: &str, reason: impl Into<String>) -> Error {
    Error::Config { key: argument.into(), reason: reason.into() }
}

impl RosArgs {
    /// Takes them out of a command line.
    ///
    /// # Errors
    /// [`Error::Config`] for one that ROS 2 does not know or that is not complete.
    pub(crate) fn split(arguments: Vec<String>) -> Result<(Vec<String>, Self)> {
        let (mut own, mut ros) = (Vec::new(), Self::default());
        let mut arguments = arguments.into_iter();
        while let Some(argument) = arguments.next() {
            if argument == "--ros-args" {
                ros.take(&mut arguments)?;
            } else {
                own.push(argument);
            }
        }
        Ok((own, ros))
    }

    fn take(&mut self, arguments: &mut impl Iterator<Item = String>) -> Result<()> {
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| bad(&argument, "has nothing after it"));
            match argument.as_str() {
                "--" => return Ok(()),
                "-r" | "--remap" => self.remap(&value()?)?,
                "-p" | "--param" => {
                    let pair = pair(&value()?)?;
                    self.parameters.push(pair);
                }
                "--params-file" => self.files.push(value()?.into()),
                "--log-level" | "--log-config-file" | "--log-file-name" | "-e" | "--enclave" => {
                    let value = value()?;
                    self.notes.push(format!("{argument} {value} does nothing here"));
                }
                other if other.starts_with("--enable-") || other.starts_with("--disable-") => {
                    self.notes.push(format!("{other} does nothing here"));
                }
                other => return Err(bad(other, "is not an argument of ROS 2")),
            }
        }
        Ok(())
    }

    fn remap(&mut self, rule: &str) -> Result<()> {
        let (from, to) = pair(rule)?;
        match from.as_str() {
            "__node" | "__name" => self.node = Some(to),
            "__ns" => self.namespace = Some(to),
            _ => self.remaps.push((from, to)),
        }
        Ok(())
    }

    /// The names of a node that is called `node` unless something else is stated.
    ///
    /// # Errors
    /// [`Error::Ros2`] for names that ROS 2 does not allow.
    pub(crate) fn naming(&self, node: &str) -> Result<Naming> {
        let node = self.node.as_deref().unwrap_or(node);
        Naming::new(node, self.namespace.as_deref().unwrap_or("/"), &self.remaps)
    }
}

/// `FROM:=TO`.
fn pair(rule: &str) -> Result<(String, String)> {
    match rule.split_once(":=") {
        Some((from, to)) if !from.is_empty() && !to.is_empty() => Ok((from.into(), to.into())),
        _ => Err(bad(rule, "is not of the form NAME:=VALUE")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str) -> Result<(Vec<String>, RosArgs)> {
        RosArgs::split(line.split(' ').map(str::to_owned).collect())
    }

    #[test]
    fn what_a_launch_file_passes_is_taken_out() {
        let line = "node -c a.yaml --ros-args -r __node:=eyes -r __ns:=/robot -r /points:=/top/points -p tau:=0.4 --params-file p.yaml -- --adapter x";
        let (own, ros) = split(line).unwrap();
        assert_eq!(own.join(" "), "node -c a.yaml --adapter x");
        let naming = ros.naming("limpid").unwrap();
        assert_eq!(naming.full_name(), "/robot/eyes");
        assert_eq!(naming.resolve("/points").unwrap(), "/top/points");
        assert_eq!(ros.parameters, [("tau".to_owned(), "0.4".to_owned())]);
        assert_eq!(ros.files, [PathBuf::from("p.yaml")]);
    }

    #[test]
    fn what_is_not_complete_or_unknown_is_named() {
        for (line, named) in
            [("--ros-args -r", "-r"), ("--ros-args -p tau", "tau"), ("--ros-args --fast", "--fast")]
        {
            let error = split(line).unwrap_err();
            assert!(matches!(&error, Error::Config { key, .. } if key == named), "{error}");
        }
    }
}
