//! What ROS 2's environment variables say, and which of it cannot be honoured.

use std::net::{IpAddr, Ipv4Addr};

use crate::base::{Error, Result};

/// Largest domain whose ports exist.
const MAX_DOMAIN: u16 = 232;

/// Largest domain whose ports are not among those that Linux gives to anybody.
const MAX_USUAL_DOMAIN: u16 = 101;

/// How a participant joins.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Environment {
    /// DDS domain.
    pub domain: u16,
    /// Whether only this machine is spoken to.
    pub localhost_only: bool,
    /// Gids of 24 bytes, as up to humble, in place of 16.
    pub long_gids: bool,
    /// What a user should know.
    pub notes: Vec<String>,
}

impl Environment {
    /// From the variables of this process.
    ///
    /// # Errors
    /// As [`Self::from_variables`].
    pub fn read() -> Result<Self> {
        Self::from_variables(&|name| std::env::var(name).ok())
    }

    /// From `variable`, which gives the value of a name.
    ///
    /// # Errors
    /// [`Error::Config`] with the variable's name for a value that has no meaning, or that asks for what cannot be done and
    /// must not be left undone: security, no discovery at all.
    pub fn from_variables(variable: &dyn Fn(&str) -> Option<String>) -> Result<Self> {
        let value = |name: &str| variable(name).filter(|value| !value.trim().is_empty());
        let mut environment = Self { domain: domain(value("ROS_DOMAIN_ID").as_deref())?, ..Self::default() };
        if environment.domain > MAX_USUAL_DOMAIN {
            environment.notes.push(format!(
                "ROS_DOMAIN_ID {} is above {MAX_USUAL_DOMAIN}: its ports may be taken by other programs",
                environment.domain
            ));
        }
        environment.localhost_only = localhost_only(&value)?;
        let distribution = value("ROS_DISTRO").unwrap_or_default();
        environment.long_gids = ["foxy", "galactic", "humble"].contains(&distribution.as_str());
        if value("ROS_SECURITY_ENABLE").is_some_and(|value| value == "true") {
            return Err(bad("ROS_SECURITY_ENABLE", "DDS security is not supported".into()));
        }
        if let Some(rmw) = value("RMW_IMPLEMENTATION").filter(|rmw| rmw.contains("zenoh")) {
            environment.notes.push(format!(
                "RMW_IMPLEMENTATION is {rmw}, but limpid speaks DDS: nodes on Zenoh do not see it"
            ));
        }
        for name in [
            "ROS_STATIC_PEERS",
            "ROS_DISCOVERY_SERVER",
            "CYCLONEDDS_URI",
            "FASTRTPS_DEFAULT_PROFILES_FILE",
            "FASTDDS_DEFAULT_PROFILES_FILE",
        ] {
            if value(name).is_some() {
                environment.notes.push(format!(
                    "{name} is set, but not read here: others are found by multicast, or on this machine"
                ));
            }
        }
        Ok(environment)
    }

    /// The networks that are used; `None`: all.
    pub(super) fn networks(&self) -> Option<[IpAddr; 1]> {
        self.localhost_only.then_some([IpAddr::V4(Ipv4Addr::LOCALHOST)])
    }
}

fn bad(name: &str, reason: String) -> Error {
    Error::Config { key: name.into(), reason }
}

fn domain(stated: Option<&str>) -> Result<u16> {
    let Some(stated) = stated else { return Ok(0) };
    match stated.trim().parse() {
        Ok(domain) if domain <= MAX_DOMAIN => Ok(domain),
        _ => Err(bad("ROS_DOMAIN_ID", format!("`{stated}` is not a whole number from 0 to {MAX_DOMAIN}"))),
    }
}

fn localhost_only(value: &dyn Fn(&str) -> Option<String>) -> Result<bool> {
    match value("ROS_LOCALHOST_ONLY").as_deref() {
        Some("1") => return Ok(true),
        None | Some("0") => {}
        Some(other) => return Err(bad("ROS_LOCALHOST_ONLY", format!("`{other}` is neither 0 nor 1"))),
    }
    match value("ROS_AUTOMATIC_DISCOVERY_RANGE").as_deref() {
        None | Some("SUBNET" | "SYSTEM_DEFAULT") => Ok(false),
        Some("LOCALHOST") => Ok(true),
        Some("OFF") => Err(bad(
            "ROS_AUTOMATIC_DISCOVERY_RANGE",
            "OFF cannot be honoured: nodes are only found by discovery; LOCALHOST keeps to this machine"
                .into(),
        )),
        Some(other) => Err(bad(
            "ROS_AUTOMATIC_DISCOVERY_RANGE",
            format!("`{other}` is none of SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Result<Environment> {
        Environment::from_variables(&|name| {
            variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).into())
        })
    }

    #[test]
    fn variables_are_honoured_or_named() {
        assert_eq!(of(&[]).unwrap(), Environment::default());
        let local = of(&[("ROS_DOMAIN_ID", "42"), ("ROS_LOCALHOST_ONLY", "1")]).unwrap();
        assert_eq!((local.domain, local.localhost_only), (42, true));
        // The older variable wins only where it is 1, as in rcl.
        let range = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"), ("ROS_LOCALHOST_ONLY", "0")];
        assert!(of(&range).unwrap().localhost_only);
        let told = of(&[("ROS_STATIC_PEERS", "10.0.0.2"), ("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")]).unwrap();
        assert_eq!(told.notes.len(), 2, "{told:?}");
        assert!(of(&[("ROS_DISTRO", "humble")]).unwrap().long_gids);
    }

    #[test]
    fn what_has_no_meaning_is_an_error_with_the_variables_name() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_DOMAIN_ID", "two"),
            ("ROS_LOCALHOST_ONLY", "yes"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost"),
            ("ROS_SECURITY_ENABLE", "true"),
        ] {
            let error = of(&[(name, value)]).unwrap_err();
            assert!(matches!(&error, Error::Config { key, .. } if key == name), "{error}");
        }
    }
}
