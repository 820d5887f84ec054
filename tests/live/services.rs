//! Clearing and saving the map, and parameters, between two participants of the product and by Cyclone DDS.

use std::process::Command;
use std::time::{Duration, Instant};

use limpid::Config;
use limpid::message::service::{
    DescribeParametersReply, GetParameterTypesReply, GetParametersReply, ListParametersReply,
    ListParametersRequest, NamesRequest, Parameter, ParameterValue, SaveMapReply, SaveMapRequest,
    SetParametersReply, SetParametersRequest, SetResult, TriggerReply,
};
use limpid::ros2::Quality;

use super::client::Client;
use super::node::{config, listener};
use super::peer::{Costs, Node, domain, no_network, node_options, play_options, played};
use super::python::python;
use crate::cli::ROOM;
use crate::support::gpu::skipped;

const RAW: u32 = 2;

fn double(name: &str, value: f64) -> Parameter {
    let value = ParameterValue { kind: 3, double_value: value, ..ParameterValue::default() };
    Parameter { name: name.into(), value }
}

#[test]
fn the_map_is_saved_and_cleared_by_a_call() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let node = Node::start(&environment, node_options(Config { timeout_s: 0.0, ..config() }));
    let save = Client::new(&environment, "/limpid/save_map", "nav2_msgs/SaveMap");
    let clear = Client::new(&environment, "/limpid/clear", "std_srvs/Trigger");
    let folder = tempfile::tempdir().unwrap();
    let asked = SaveMapRequest {
        map_url: folder.path().join("kept").to_str().unwrap().into(),
        ..SaveMapRequest::default()
    };
    assert!(!save.call::<_, SaveMapReply>(&asked).result, "there is no map yet");
    played(&environment, ROOM, &play_options()).unwrap();
    peer.wait_for::<Costs>(RAW, |costs| costs.data.contains(&0));
    assert!(save.call::<_, SaveMapReply>(&asked).result);
    let picture = std::fs::read(folder.path().join("kept.pgm")).unwrap();
    assert!(picture.starts_with(b"P5\n240 240\n255\n") && picture[15..].contains(&254));
    assert!(std::fs::read_to_string(folder.path().join("kept.yaml")).unwrap().contains("kept.pgm"));
    for wrong in [
        SaveMapRequest { image_format: "png".into(), ..asked.clone() },
        SaveMapRequest { map_mode: "scale".into(), ..asked.clone() },
        SaveMapRequest { map_topic: "/map".into(), ..asked.clone() },
        SaveMapRequest { map_url: "/no/such/folder/map".into(), ..asked.clone() },
    ] {
        assert!(!save.call::<_, SaveMapReply>(&wrong).result, "{wrong:?}");
    }
    node.wait_for("`png` is not written", 1);
    node.wait_for("the map of `/map` is not limpid's", 1);

    assert!(clear.call::<_, TriggerReply>(&0_u8).success);
    peer.wait_for::<Costs>(RAW, |costs| costs.data.iter().all(|&cost| cost == 255));
    node.wait_for("the map begins anew: ~/clear was called", 1);
    node.end();
}

#[test]
fn parameters_are_listed_described_and_set() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let mut peer = super::peer::Peer::join(&environment);
    peer.listen(0, "/parameter_events", "rcl_interfaces/msg/ParameterEvent", Quality::Stream { depth: 10 });
    let node = Node::start(&environment, node_options(Config { publish_rate_hz: 10.0, ..config() }));
    let client = |name: &str, of: &str| {
        Client::new(&environment, &format!("/limpid/{name}"), &format!("rcl_interfaces/{of}"))
    };
    let list: ListParametersReply =
        client("list_parameters", "ListParameters").call(&ListParametersRequest::default());
    assert!(list.names.len() > 100 && list.names.contains(&"tau".into()), "{list:?}");
    let names = NamesRequest { names: vec!["tau".into(), "no_such".into(), "publish_rate_hz".into()] };
    let get = client("get_parameters", "GetParameters");
    let values = get.call::<_, GetParametersReply>(&names).values;
    assert_eq!((values[0].kind, values[1].kind, values[2].double_value), (3, 0, 10.0));
    let types: GetParameterTypesReply = client("get_parameter_types", "GetParameterTypes").call(&names);
    assert_eq!(types.types, [3, 0, 3]);
    let described: DescribeParametersReply = client("describe_parameters", "DescribeParameters").call(&names);
    let read_only: Vec<_> = described.descriptors.iter().map(|of| of.read_only).collect();
    assert_eq!(read_only, [true, true, false]);
    assert!(described.descriptors[2].description.contains("Hz"), "{described:?}");

    let set = client("set_parameters", "SetParameters");
    let asked = SetParametersRequest { parameters: vec![double("publish_rate_hz", 5.0), double("tau", 0.9)] };
    let results = set.call::<_, SetParametersReply>(&asked).results;
    assert!(results[0].successful && !results[1].successful, "{results:?}");
    assert!(results[1].reason.contains("-p tau:=0.9"), "{results:?}");
    let all = client("set_parameters_atomically", "SetParametersAtomically");
    let asked = SetParametersRequest { parameters: vec![double("wait_s", 3.0), double("wait_s", -1.0)] };
    let refused: SetResult = all.call(&asked);
    assert!(!refused.successful && refused.reason.contains("wait_s"), "{refused:?}");
    let names = NamesRequest { names: vec!["publish_rate_hz".into(), "wait_s".into()] };
    let values = get.call::<_, GetParametersReply>(&names).values;
    assert_eq!([values[0].double_value, values[1].double_value], [5.0, 20.0]);
    let (_, event) = peer.next(Instant::now() + Duration::from_secs(20)).expect("the change is told");
    assert!(event.windows(15).any(|part| part == b"publish_rate_hz"), "{event:?}");

    // What is no request gets no reply and does no harm.
    let nonsense = set.ask(&u32::MAX);
    assert!(set.reply::<SetParametersReply>(nonsense, Instant::now() + Duration::from_millis(500)).is_none());
    node.wait_for("a request was not understood", 1);
    assert_eq!(get.call::<_, GetParametersReply>(&names).values.len(), 2);
    node.end();
}

#[test]
fn cyclone_dds_calls_as_its_rmw_does() {
    if no_network() || skipped() {
        return;
    }
    let Some(python) = python() else { return };
    let environment = domain();
    let node = Node::start(&environment, node_options(config()));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live/caller.py");
    let output = Command::new(python).args([script, &environment.domain.to_string()]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().collect::<Vec<_>>(), ["clear True", "types 3 0 4"]);
    node.end();
}
