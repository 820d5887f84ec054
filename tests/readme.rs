//! What the README shows is what limpid does.

use limpid::Config;
use limpid::config::SensorKind;
use limpid::map::rule::rule_markdown;

use crate::support::readme_part;

#[test]
fn the_readme_shows_the_rule() {
    let table = rule_markdown();
    assert_eq!(
        readme_part("rule"),
        table.trim(),
        "README.md should hold between its <!-- rule --> markers:\n\n{table}\n"
    );
}

#[test]
fn the_readme_s_robot_is_a_configuration() {
    let part = readme_part("robot");
    let yaml = part.trim_start_matches("```yaml").trim_end_matches("```");
    let config = Config::from_yaml(yaml).unwrap();
    let sensors: Vec<_> = config.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.kind)).collect();
    let want = [("front", SensorKind::Camera), ("rear", SensorKind::Camera), ("top", SensorKind::Lidar)];
    assert_eq!(sensors, want);
    assert!(config.sensors[2].parameters.glass);
}
