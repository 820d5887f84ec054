//! Is memory flat over 10,000 frames? `cargo bench --bench soak [-- FRAMES] [drm]`
//!
//! Method range, or with `drm` that one.
//! One mapper; the recording is opened, decoded and written out anew every 30 frames, so that readers
//! and writers are soaked too. Fails where host memory or any GPU count grows after the first tenth.

use std::path::Path;

use limpid::config::Method;
use limpid::input::open_source;
use limpid::mapper::{Mapper, Options, Submitted};
use limpid::output::{McapSink, Sink};
use limpid::sensor::Observation;
use limpid::{Config, Error, Result};

/// Growth of resident memory that counts as flat: allocators keep some pages back.
const FLAT_KIB: u64 = 2048;

/// What must not grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Memory {
    resident_kib: u64,
    gpu_buffers: isize,
    gpu_bytes: isize,
    gpu_allocations: isize,
    bind_groups: isize,
}

fn measure(mapper: &Mapper) -> Memory {
    let hal = mapper.context().counters().hal;
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = statm.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0);
    Memory {
        resident_kib: pages * 4,
        gpu_buffers: hal.buffers.read(),
        gpu_bytes: hal.buffer_memory.read(),
        gpu_allocations: hal.memory_allocations.read(),
        bind_groups: hal.bind_groups.read(),
    }
}

/// One round through the recording into a file that is written anew.
fn round(mapper: &mut Mapper, input: &Path, config: &Config, output: &Path) -> Result<u64> {
    let mut source = open_source(input, config)?;
    let mut sink = McapSink::create(output, config, source.sensors())?;
    let mut under_way: Vec<Observation> = Vec::new();
    let mut frames = 0;
    let mut take = |mapper: &mut Mapper, under_way: &mut Vec<Observation>| -> Result<()> {
        let update = mapper.wait()?;
        let frame = under_way.remove(0);
        frames += 1;
        update.map_or(Ok(()), |update| sink.write(&update, Some(&frame)))
    };
    while let Some(frame) = source.next()? {
        while mapper.is_full(0) {
            take(mapper, &mut under_way)?;
        }
        if let Submitted::Refused(reason) = mapper.submit(&frame)? {
            return Err(Error::Input { what: "testdata/room.mcap".into(), reason: reason.to_string() });
        }
        under_way.push(frame);
    }
    while !under_way.is_empty() {
        take(mapper, &mut under_way)?;
    }
    sink.finish()?;
    Ok(frames)
}

fn main() -> Result<()> {
    let wanted: u64 = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(10_000);
    let input = Path::new("testdata/room.mcap");
    let output = std::env::temp_dir().join(format!("limpid-soak-{}.mcap", std::process::id()));
    let drm = std::env::args().any(|argument| argument == "drm");
    let config = Config { method: if drm { Method::Drm } else { Method::Range }, ..Config::default() };
    let source = open_source(input, &config)?;
    let options = Options { images: true, layers: true, verdicts: true, ..Options::default() };
    let mut mapper = Mapper::open(&config, source.sensors(), &options)?;
    println!("{}", mapper.context().describe());
    println!("| frames | resident KiB | GPU buffers | GPU bytes | GPU allocations | bind groups |");
    println!("|---|---|---|---|---|---|");
    let (mut done, mut settled, mut next_row) = (0, None, 0);
    while done < wanted {
        if done >= next_row {
            let now = measure(&mapper);
            print_row(done, now);
            if done >= wanted / 10 {
                settled.get_or_insert(now);
            }
            next_row += wanted.div_ceil(10);
        }
        done += round(&mut mapper, input, &config, &output)?;
    }
    std::fs::remove_file(&output).map_err(Error::file(&output))?;
    let end = measure(&mapper);
    print_row(done, end);
    judge(settled.unwrap_or(end), end)
}

fn print_row(frames: u64, m: Memory) {
    let Memory { resident_kib, gpu_buffers, gpu_bytes, gpu_allocations, bind_groups } = m;
    println!(
        "| {frames} | {resident_kib} | {gpu_buffers} | {gpu_bytes} | {gpu_allocations} | {bind_groups} |"
    );
}

fn judge(settled: Memory, end: Memory) -> Result<()> {
    let gpu_same = Memory { resident_kib: 0, ..settled } == Memory { resident_kib: 0, ..end };
    let grown_kib = end.resident_kib.saturating_sub(settled.resident_kib);
    if gpu_same && grown_kib <= FLAT_KIB {
        println!("flat: resident memory grew by {grown_kib} KiB, GPU counts not at all");
        return Ok(());
    }
    Err(Error::Gpu { what: "soak".into(), reason: format!("memory grew: {settled:?} to {end:?}") })
}
