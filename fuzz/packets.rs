//! Any bytes as Velodyne packets and messages of them: counted or finite points, at most 384 a packet.
#![no_main]

use libfuzzer_sys::fuzz_target;
use limpid::input::ReadReport;
use limpid::input::points::Options;
use limpid::input::points::velodyne::{Cut, Decoder, PACKET_BYTES, ScanMessage};
use limpid::sensor::VelodyneModel as Model;

fn decode<'a>(packets: impl Iterator<Item = &'a [u8]>, model: Option<Model>) {
    let options = Options { model, ..Options::default() };
    let (mut decoder, mut report) = (Decoder::new("", "", &options), ReadReport::default());
    let (mut pushed, mut points) = (0, 0);
    for packet in packets {
        // Blocks as they should be, or hardly any packet would pass.
        let mut packet = packet.to_vec();
        packet[..1200].chunks_mut(100).for_each(|block| block[..2].copy_from_slice(&[0xff, 0xee]));
        packet[1204] = 0x37 + packet[1204] % 3;
        decoder.push(&packet, 0, Cut::AtWrap, &mut report);
        pushed += 1;
    }
    decoder.finish(&mut report);
    while let Some(scan) = decoder.pop() {
        points += scan.points.len();
        let finite = |point: &limpid::sensor::Point| point.position_m().iter().all(|value| value.is_finite());
        assert!(scan.points.iter().all(finite));
    }
    assert!(points <= 384 * pushed);
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let model = Model::ALL.get(usize::from(kind % 8)).copied();
    decode(bytes.chunks_exact(PACKET_BYTES), model);
    for message in [ScanMessage::from_cdr(bytes), ScanMessage::from_ros1(bytes)].into_iter().flatten() {
        assert!(message.packets.len() * PACKET_BYTES <= bytes.len());
        message.is_revolution();
        decode(message.packets.iter().map(|packet| packet.payload), model);
    }
});
