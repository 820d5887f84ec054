//! Training samples: reference depth of whole recordings against the truth, files, and what is refused.

use std::collections::VecDeque;
use std::path::Path;

use limpid::Error;
use limpid::base::Rigid;
use limpid::input::{ReadReport, Recording};
use limpid::offline::targets::{Request, Sample, SampleFile, make};
use limpid::sensor::{ColorImage, DepthSamples, RgbdFrame};
use safetensors::{Dtype, SafeTensors};

use crate::sim::record_small_room;
use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose, small_camera};

/// Frames in memory.
struct Frames(VecDeque<RgbdFrame>, ReadReport);

impl Recording for Frames {
    fn next_frame(&mut self) -> limpid::Result<Option<RgbdFrame>> {
        Ok(self.0.pop_front())
    }

    fn report(&self) -> &ReadReport {
        &self.1
    }

    fn frame_count_hint(&self) -> Option<u64> {
        None
    }
}

fn scene() -> Scene {
    Scene::of(&[Block::new([2.0, -0.4, 0.0], [2.5, 0.3, 0.7]), Block::new([3.5, -4.0, 0.0], [4.0, 4.0, 2.0])])
}

/// A drive towards a box and a wall; `spoil` changes the depth that is measured.
fn drive(count: u64, spoil: impl Fn(u64, &mut [f32])) -> Vec<RgbdFrame> {
    let camera = small_camera();
    let frame = |index: u64| {
        let place = pose(0.03 * index as f64, 0.0, 0.02 * index as f64, 0.6, 0.3);
        let mut frame = scene().frame(index, camera, place);
        let DepthSamples::Metres(depth) = &mut frame.depth.samples else { unreachable!() };
        spoil(index, depth);
        let rgb = vec![90; 3 * depth.len()];
        frame.color = Some(ColorImage { stamp_ns: frame.depth.stamp_ns, camera, rgb });
        frame.color_from_depth = Some(Rigid::IDENTITY);
        frame
    };
    (0..count).map(frame).collect()
}

fn samples(frames: &[RgbdFrame], request: &Request) -> limpid::Result<Vec<Sample>> {
    let mut samples = Vec::new();
    let mut recording = Frames(frames.to_vec().into(), ReadReport::default());
    make(Path::new("drive.bag"), &mut recording, request, &mut |sample| {
        samples.push(sample.clone());
        Ok(())
    })?;
    Ok(samples)
}

/// Holes, spikes and things that are not there: a third of the pixels is wrong, elsewhere in every frame.
fn glare(index: u64, depth: &mut [f32]) {
    let mut random = Random(index + 1);
    for d in depth {
        match random.below(9) {
            0 => *d = 0.0,
            1 => *d *= 1.5 + random.unit(),
            2 => *d *= 0.9 - 0.5 * random.unit(),
            _ => {}
        }
    }
}

#[test]
fn truth_a_reference_from_spoilt_frames_is_the_true_depth() {
    if skipped() {
        return;
    }
    let spoilt = samples(&drive(20, glare), &Request::default()).unwrap();
    let clean = samples(&drive(20, |_, _| ()), &Request::default()).unwrap();
    assert_eq!(spoilt.iter().map(|s| s.index).collect::<Vec<_>>(), (0..20).collect::<Vec<_>>());
    for (spoilt, clean) in spoilt.iter().zip(&clean) {
        let (mut covered, mut wrong, mut known, mut misjudged) = (0, 0, 0, 0);
        for pixel in 0..clean.depth_m.len() {
            let (reference, truth) = (spoilt.measured.reference_m[pixel], clean.depth_m[pixel]);
            if truth == 0.0 {
                continue;
            }
            known += 1;
            if reference > 0.0 {
                covered += 1;
                wrong += u32::from((reference - truth).abs() > 0.03 * truth);
                let good = (spoilt.depth_m[pixel] - truth).abs() < 0.01 * truth;
                misjudged += u32::from(good != (spoilt.measured.binary[pixel] > 0.5));
            }
        }
        let share = |part: u32, of: u32| f64::from(part) / f64::from(of);
        // Edges of the box are seen half a pixel aside; the first and last frames see places that no other does.
        let middle = (6..14).contains(&spoilt.index);
        let least = if middle { 0.85 } else { 0.5 };
        let told = format!(
            "frame {}: {known} known, {covered} covered, {wrong} wrong, {misjudged} misjudged",
            spoilt.index
        );
        assert!(share(covered, known) > least, "{told}");
        assert!(share(wrong, covered) < 0.03 && share(misjudged, covered) < 0.06, "{told}");
    }
}

#[test]
fn control_what_spoils_every_frame_alike_becomes_the_reference() {
    if skipped() {
        return;
    }
    // A mirror's image is as steady as a wall: no filter over frames can tell.
    let sunk = samples(&drive(9, |_, depth| depth.iter_mut().for_each(|d| *d *= 1.3)), &Request::default());
    let clean = samples(&drive(9, |_, _| ()), &Request::default()).unwrap();
    let (sunk, clean) = (&sunk.unwrap()[4], &clean[4]);
    let ratio = |pixel: usize| sunk.measured.reference_m[pixel] / clean.depth_m[pixel];
    let seen: Vec<f32> = (0..clean.depth_m.len())
        .filter(|&p| sunk.measured.reference_m[p] > 0.0 && clean.depth_m[p] > 0.0)
        .map(ratio)
        .collect();
    let near = seen.iter().filter(|r| (*r - 1.3).abs() < 0.05).count();
    assert!(seen.len() > 20_000 && near * 10 > seen.len() * 8, "{near} of {}", seen.len());
}

#[test]
fn the_same_frames_give_the_same_bits() {
    if skipped() {
        return;
    }
    let frames = drive(10, glare);
    let once = samples(&frames, &Request::default()).unwrap();
    assert_eq!(once, samples(&frames, &Request::default()).unwrap());
    let some = samples(&frames, &Request { every: 4, ..Request::default() }).unwrap();
    let every_fourth: Vec<&Sample> = once.iter().step_by(4).collect();
    assert_eq!(some.iter().collect::<Vec<_>>(), every_fourth);
}

#[track_caller]
fn refused(frames: &[RgbdFrame], parts: &[&str]) {
    let reason = samples(frames, &Request::default()).unwrap_err().to_string();
    assert!(parts.iter().all(|part| reason.contains(part)), "{reason}");
}

#[test]
fn frames_that_cannot_serve_are_named() {
    if skipped() {
        return;
    }
    let frames = drive(9, |_, _| ());
    let with = |change: &dyn Fn(&mut RgbdFrame)| {
        let mut frames = frames.clone();
        change(&mut frames[6]);
        frames
    };
    refused(&with(&|f| f.color = None), &["colour image of frame 6", "is missing"]);
    refused(&with(&|f| f.color_from_depth = None), &["colour image of frame 6"]);
    refused(&with(&|f| f.depth.camera.fx += 1.0), &["calibration of frame 6", "changes"]);
    refused(&with(&|f| f.depth.samples = DepthSamples::Metres(vec![1.0])), &["frame 6`: depth image"]);
    refused(&frames[..4], &["frame 0", "3 other frames", "4 are needed"]);
    let mut apart = frames.clone();
    for frame in &mut apart {
        let turn = f64::from(u32::try_from(frame.index).unwrap()) * 2.0;
        frame.pose = Some(pose(0.0, 0.0, turn, 0.6, 0.3));
    }
    refused(&apart, &["frame 0", "seen alike"]);
    let mut lost = frames.clone();
    lost.iter_mut().for_each(|frame| frame.pose = None);
    refused(&lost, &["none of its 9 frames has a pose"]);
    refused(&[], &["0 depth images"]);
    let nan = with(&|f| f.pose.as_mut().unwrap().map_from_base.translation_m.x = f64::NAN);
    refused(&nan, &["frame 6`", "not finite"]);
    let request = Request { needs_truth: true, ..Request::default() };
    assert!(
        matches!(samples(&frames, &request), Err(Error::Format { reason, .. }) if reason.contains("no ground truth"))
    );
    let few = with(&|f| f.pose = None);
    assert_eq!(samples(&few, &Request::default()).unwrap().len(), 8);
}

#[test]
fn poisoned_depth_gives_finite_samples() {
    if skipped() {
        return;
    }
    let poison = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX, 0.0];
    let spoil = |index: u64, depth: &mut [f32]| {
        for (at, d) in depth.iter_mut().enumerate().skip(index as usize % 5).step_by(5) {
            *d = poison[at % poison.len()];
        }
    };
    for sample in samples(&drive(9, spoil), &Request::default()).unwrap() {
        let measured = &sample.measured;
        let all = [&sample.input, &sample.depth_m, &measured.reference_m, &measured.soft, &measured.binary];
        assert!(all.into_iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "frame {}", sample.index);
    }
}

fn limpid(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_limpid")).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// A recording of the small room in a folder of its own.
fn recorded(frames: u32) -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (recording, samples) = (at("room.mcap"), at("samples"));
    record_small_room(Path::new(&recording), frames);
    (folder, recording, samples)
}

#[test]
fn the_command_writes_samples_of_simulated_recordings_and_says_how_far_off_they_are() {
    if skipped() {
        return;
    }
    let (_folder, recording, samples) = recorded(9);
    let (code, out, err) = limpid(&["targets", &recording, "--truth", "--baseline", "0.3", "-o", &samples]);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("9 samples") && out.contains("covered") && out.contains("matt"), "{out}");
    let bytes = std::fs::read(Path::new(&samples).join("room.safetensors")).unwrap();
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    let is = |name: &str, dtype: Dtype, shape: &[usize]| {
        let tensor = tensors.tensor(name).unwrap();
        assert!(tensor.dtype() == dtype && tensor.shape() == shape, "{name}: {:?}", tensor.shape());
    };
    is("input", Dtype::F32, &[9, 5, 240, 320]);
    for name in ["reference_m", "soft", "true_depth_m", "true_soft"] {
        is(name, Dtype::F32, &[9, 240, 320]);
    }
    for name in ["binary", "true_binary", "material"] {
        is(name, Dtype::U8, &[9, 240, 320]);
    }
    is("frame", Dtype::I64, &[9]);
    is("stamp_ns", Dtype::I64, &[9]);
    near_the_truth(&tensors);
}

/// Where there is a reference, it lies near the true depth and judges nearly as that does.
fn near_the_truth(tensors: &SafeTensors<'_>) {
    let bytes_of = |name: &str| tensors.tensor(name).unwrap().data().to_vec();
    let metres = |name: &str| -> Vec<f32> {
        bytes_of(name).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
    };
    let (reference, truth) = (metres("reference_m"), metres("true_depth_m"));
    let (binary, true_binary) = (bytes_of("binary"), bytes_of("true_binary"));
    let known: Vec<usize> = (0..binary.len()).filter(|&p| reference[p] > 0.0 && truth[p] > 0.0).collect();
    let alike = known.iter().filter(|&&p| binary[p] == true_binary[p]).count();
    let mut errors: Vec<f32> = known.iter().map(|&p| (reference[p] - truth[p]).abs() / truth[p]).collect();
    errors.sort_by(f32::total_cmp);
    let median = errors[errors.len() / 2];
    let told =
        format!("{} of {} known, {alike} judged alike, median error {median}", known.len(), binary.len());
    // Pixels of this small image are wide: the floor falls by several of the tolerances within one.
    assert!(known.len() * 2 > binary.len() && alike * 10 > known.len() * 8 && median < 0.015, "{told}");
}

#[test]
fn the_command_says_what_is_wrong() {
    if skipped() {
        return;
    }
    let (_folder, recording, samples) = recorded(3);
    let refused = |input: &str, more: &[&str], code: i32, parts: &[&str]| {
        let (got, _, err) = limpid(&[&["targets", input, "-o", &samples], more].concat());
        assert!(got == Some(code) && parts.iter().all(|part| err.contains(part)), "{got:?}: {err}");
    };
    refused(&recording, &[], 1, &["frame 0", "2 other frames"]);
    refused("testdata/room.mcap", &["--truth"], 1, &["room.mcap", "no ground truth"]);
    refused(&recording, &["--baseline", "0"], 2, &["positive"]);
    refused(&recording, &["--every", "0"], 2, &["--every"]);
    refused("no/such.mcap", &[], 1, &["no/such.mcap"]);
}

#[test]
fn long_recordings_go_on_in_another_file() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let sample = &samples(&drive(5, |_, _| ()), &Request::default()).unwrap()[2];
    let mut file = SampleFile::create(folder.path(), Path::new("far/long.mcap")).unwrap();
    for index in 0..66 {
        file.add(&Sample { index, ..sample.clone() }).unwrap();
    }
    let written = file.finish().unwrap();
    let counts: Vec<usize> = written
        .iter()
        .map(|path| {
            let bytes = std::fs::read(path).unwrap();
            SafeTensors::deserialize(&bytes).unwrap().tensor("frame").unwrap().shape()[0]
        })
        .collect();
    assert_eq!(counts, [64, 2]);
    assert!(written[0].ends_with("long.safetensors") && written[1].ends_with("long-1.safetensors"));
    let blocked = folder.path().join("long.safetensors");
    assert!(
        matches!(SampleFile::create(&blocked, Path::new("x.mcap")), Err(Error::File { path, .. }) if path == blocked)
    );
}
