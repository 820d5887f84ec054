//! The bits of every recording's results as they were stored: code that is rebuilt gives the same.

mod cases;
mod products;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use self::products::{Product, fnv1a, machine};
use crate::support::gpu::skipped;
use crate::support::say;

const STORED: &str = "testdata/reference/golden.json";

/// Hashes of each product, frame by frame in order.
type Hashes = BTreeMap<String, Vec<String>>;

/// The hashes of each case.
type Cases = BTreeMap<String, Hashes>;

/// The stored file.
#[derive(serde::Deserialize)]
struct Golden {
    adapter: String,
    cpu: String,
    cases: Cases,
}

fn by_product(products: &[Product]) -> Hashes {
    let mut hashes = Hashes::new();
    for product in products {
        hashes.entry(product.name.into()).or_default().push(format!("{:016x}", product.hash));
    }
    hashes
}

/// Case, product and frames of what differs; empty where nothing does.
fn differences(stored: &Cases, made: &Cases) -> Vec<String> {
    let none = Hashes::new();
    let names: BTreeSet<_> = stored.keys().chain(made.keys()).collect();
    let hashes = |cases: &'_ Cases, name: &String| cases.get(name).unwrap_or(&none).clone();
    names
        .into_iter()
        .flat_map(|name| case_differences(name, &hashes(stored, name), &hashes(made, name)))
        .collect()
}

fn case_differences(name: &str, stored: &Hashes, made: &Hashes) -> Vec<String> {
    let products: BTreeSet<_> = stored.keys().chain(made.keys()).collect();
    let mut found = Vec::new();
    for product in products {
        let list = |hashes: &Hashes| hashes.get(product).cloned().unwrap_or_default();
        let (old, new) = (list(stored), list(made));
        let most = old.len().max(new.len());
        let frames: Vec<_> = (0..most).filter(|&at| old.get(at) != new.get(at)).collect();
        if !frames.is_empty() {
            let counts = format!("{} stored, {} made", old.len(), new.len());
            found.push(format!("{name}: {product} of frames {frames:?} ({counts})"));
        }
    }
    found
}

fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap()
}

/// Stores the hashes, one case a line.
fn store([adapter, cpu]: &[String; 2], made: &Cases) {
    let lines: Vec<_> =
        made.iter().map(|(name, hashes)| format!("{}: {}", json(name), json(hashes))).collect();
    let head = format!("{{\"adapter\": {}, \"cpu\": {}, \"cases\": {{", json(adapter), json(cpu));
    std::fs::write(STORED, format!("{head}\n{}\n}}}}\n", lines.join(",\n"))).unwrap();
}

/// Runs all cases whose recordings are there, and names the others.
fn make() -> (Cases, Vec<String>) {
    let (mut made, mut left_out) = (Cases::new(), Vec::new());
    for case in cases::all() {
        if !case.recording.exists() {
            left_out.push(case.name);
            continue;
        }
        let start = Instant::now();
        let hashes = by_product(&case.products());
        println!("{}: {} frames in {:.2?}", case.name, hashes["moment"].len(), start.elapsed());
        made.insert(case.name, hashes);
    }
    (made, left_out)
}

#[test]
fn recordings_give_the_stored_bits() {
    if skipped() {
        return;
    }
    let here = machine();
    if std::env::var("LIMPID_GOLDEN").is_ok_and(|value| value == "write") {
        let (made, left_out) = make();
        assert!(left_out.is_empty(), "every recording is needed to write {STORED}: {left_out:?}");
        return store(&here, &made);
    }
    let mut stored: Golden = serde_json::from_str(&std::fs::read_to_string(STORED).unwrap()).unwrap();
    let there = [stored.adapter, stored.cpu];
    if there != here {
        return say(&format!("golden hashes left out: they are of {there:?}, this is {here:?}"));
    }
    let (made, left_out) = make();
    if !left_out.is_empty() {
        say(&format!("golden hashes left out (set LIMPID_DATA): {}", left_out.join(", ")));
    }
    for name in &left_out {
        assert!(stored.cases.remove(name).is_some(), "{name} is not stored");
    }
    let found = differences(&stored.cases, &made);
    assert!(found.is_empty(), "other bits than stored:\n{}", found.join("\n"));
}

#[test]
fn the_hash_is_fnv_1a() {
    // From the hash's reference (draft-eastlake-fnv).
    let of = |text: &str| fnv1a(&[text.as_bytes()]);
    assert_eq!(
        [of(""), of("a"), of("foobar")],
        [0xcbf2_9ce4_8422_2325, 0xaf63_dc4c_8601_ec8c, 0x8594_4171_f739_67e8]
    );
}

fn drive(costmaps: &[Vec<u8>]) -> Cases {
    let costmaps = costmaps.iter().map(|cells| Product::new("costmap", &[cells]));
    let layers = (0..3_u8).map(|frame| Product::new("layers", &[&[frame]]));
    Cases::from([("drive range".into(), by_product(&costmaps.chain(layers).collect::<Vec<_>>()))])
}

#[test]
fn control_a_flipped_bit_in_a_costmap_is_named() {
    let costmaps = vec![vec![0_u8; 57_600]; 3];
    let stored = drive(&costmaps);
    assert_eq!(differences(&stored, &drive(&costmaps)), Vec::<String>::new());
    let mut flipped = costmaps.clone();
    flipped[1][31_234] ^= 4;
    assert_eq!(
        differences(&stored, &drive(&flipped)),
        ["drive range: costmap of frames [1] (3 stored, 3 made)"]
    );
    let shorter = differences(&stored, &drive(&costmaps[..2]));
    assert_eq!(shorter, ["drive range: costmap of frames [2] (3 stored, 2 made)"]);
    let absent = differences(&stored, &Cases::new());
    assert_eq!(absent.len(), 2, "a case that is not made is named too: {absent:?}");
}

#[test]
fn control_another_ground_gives_other_bits_of_the_map_alone() {
    if skipped() {
        return;
    }
    let case = cases::all().into_iter().find(|case| case.name == "room range").unwrap();
    let made = |products: &[Product]| Cases::from([(case.name.clone(), by_product(products))]);
    let usual = made(&case.products());
    assert_eq!(differences(&usual, &made(&case.products())), Vec::<String>::new());
    let found = differences(&usual, &made(&case.products_with("ground_z_m: 0.01")));
    let named = |product: &str| found.iter().any(|line| line.contains(&format!(": {product} of")));
    assert!(named("costmap") && named("layers") && named("counters"), "{found:?}");
    assert!(!named("moment") && !named("pose") && !named("depth") && !named("color"), "{found:?}");
}
