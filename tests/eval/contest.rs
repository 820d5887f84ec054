//! The methods side by side on an analytic scene.

use crate::support::run::Pipeline;
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::{Fusion, Method};
use limpid::offline::eval::contest::is_frontier;
use limpid::offline::eval::{Contest, contestants, frontier};
use limpid::sensor::{ColorImage, RgbdFrame};

use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::run::{all, step};
use crate::support::scene::{Block, Scene, pose, small_camera};

fn config(fusion: Fusion) -> Config {
    // Forgets fast, so that three frames settle what is occupied.
    Config {
        weights: "testdata/reference/network.safetensors".into(),
        fusion,
        lambda: 0.2,
        ..Config::default()
    }
}

/// A wall in noise for colour.
fn frame(index: u64) -> RgbdFrame {
    let scene = Scene::of(&[Block::new([1.53, -1.0, 0.0], [1.7, 1.0, 1.5])]);
    let camera = small_camera();
    let mut frame = scene.frame(index, camera, pose(0.01, 0.02, 0.0, 0.6, 0.2));
    let mut random = Random(index);
    let rgb = (0..3 * 160 * 120).map(|_| random.below(256) as u8).collect();
    frame.color = Some(ColorImage { stamp_ns: frame.depth.stamp_ns, camera, rgb });
    frame.color_from_depth = Some(Rigid::IDENTITY);
    frame
}

#[test]
fn methods_are_those_of_the_spec() {
    let keys = |config: &Config| contestants(config).iter().map(|c| c.key).collect::<Vec<_>>();
    let baselines = ["naive", "range", "median", "temporal", "naive_3_hits"];
    let fusions = [Fusion::Weight, Fusion::Gate, Fusion::Evidence, Fusion::Learned];
    for (fusion, of_drm) in fusions.into_iter().zip([
        ["drm", "drm_learned", "drm_evidence", "drm_gate"],
        ["drm", "drm_learned", "drm_evidence", "drm_weight"],
        ["drm", "drm_learned", "drm_weight", "drm_gate"],
        ["drm", "drm_evidence", "drm_weight", "drm_gate"],
    ]) {
        assert_eq!(keys(&config(fusion)), [baselines.as_slice(), &of_drm].concat());
        let all = contestants(&config(fusion));
        assert!(all[..5].iter().all(|c| c.config.fusion == Fusion::Weight), "baselines have the paper's");
        assert!(frontier(&config(fusion)).iter().all(|c| is_frontier(c.key) && c.config.fusion == fusion));
    }
    assert_eq!(contestants(&config(Fusion::Auto)), contestants(&config(Fusion::Learned)));
    assert_eq!(frontier(&config(Fusion::Auto)), frontier(&config(Fusion::Learned)));
    // Cells of a side that the network does not know.
    let coarse = |fusion| Config { resolution_m: 0.1, ..config(fusion) };
    assert_eq!(contestants(&coarse(Fusion::Auto)), contestants(&coarse(Fusion::Evidence)));
    assert!(!keys(&coarse(Fusion::Auto)).contains(&"drm_learned"));
    assert!(!is_frontier("drm"));
    let all = contestants(&Config { min_hits: 5, lambda: 0.8, ..config(Fusion::Gate) });
    assert!(all.iter().all(|c| c.config.lambda == 0.8 && c.config.min_hits == 5), "map settings are shared");
    assert_eq!(contestants(&Config::default())[4].config.min_hits, 3);
}

#[test]
fn both_fusions_get_what_they_would_alone() {
    if skipped() {
        return;
    }
    let mut both = contestants(&config(Fusion::Weight)).split_off(5);
    both.retain(|contestant| !["drm_learned", "drm_evidence"].contains(&contestant.key));
    let both = &both;
    let mut contest = Contest::open(both, &frame(0), None).unwrap();
    let alone = |fusion| {
        let config = Config { method: Method::Drm, ..config(fusion) };
        Pipeline::open(&config, &frame(0), &all().with_color_of(std::iter::once(&frame(0)))).unwrap()
    };
    let [mut weight, mut gate] = [Fusion::Weight, Fusion::Gate].map(alone);
    let mut differ = false;
    for index in 0..3 {
        let entries = contest.step(&frame(index)).unwrap();
        let [drm, drm_gate] = [0, 1].map(|i| &entries[i]);
        assert_eq!((drm.key, drm_gate.key), ("drm", "drm_gate"));
        let (weight, gate) = (step(&mut weight, &frame(index)), step(&mut gate, &frame(index)));
        assert_eq!(drm.map().unwrap().costmap, weight.costmap);
        assert_eq!(drm_gate.map().unwrap().costmap, gate.costmap);
        let reliability = &weight.images.as_ref().unwrap().reliability;
        assert_eq!(&drm_gate.images().unwrap().reliability, reliability);
        // Gated evidence is 0, 1 or none; weighted evidence is the mean reliability.
        let evidence = |out: &crate::support::run::FrameOutput| out.layers.as_ref().unwrap().evidence.clone();
        assert!(evidence(&gate).iter().all(|&e| [-1.0, 0.0, 1.0].contains(&e)));
        assert!(evidence(&weight).iter().any(|&e| e > 0.0 && e < 0.999));
        differ |= weight.costmap != gate.costmap;
    }
    assert!(differ, "weights near 0.5 never reach 0.7, gated ones do");
}

#[test]
fn unless_stated_drm_has_evidence_judged_by_the_network_and_range_the_mean() {
    if skipped() {
        return;
    }
    let occupancy = |method, fusion| {
        let config = Config { method, ..config(fusion) };
        let options = all().with_color_of(std::iter::once(&frame(0)));
        let mut pipeline = Pipeline::open(&config, &frame(0), &options).unwrap();
        let outs = [0, 1].map(|index| step(&mut pipeline, &frame(index)));
        outs.map(|out| out.layers.as_ref().unwrap().occupancy.clone())
    };
    for (method, taken, other) in [
        (Method::Drm, Fusion::Learned, Fusion::Weight),
        (Method::Auto, Fusion::Learned, Fusion::Weight),
        (Method::Range, Fusion::Weight, Fusion::Evidence),
    ] {
        let unless_stated = occupancy(method, Fusion::Auto);
        assert!(unless_stated[1].iter().any(|&p| p > 0.0));
        assert_eq!(unless_stated, occupancy(method, taken), "{method:?}");
        assert_ne!(unless_stated, occupancy(method, other), "{method:?}");
    }
}
