//! Changed and random containers: errors or frames, never a panic. The targets in `fuzz/` run the same for longer.

use prop::collection::vec;
use prop::sample::Index;
use proptest::prelude::*;

use super::{FRAMES, Message, db3, folder, mcap, messages, metadata, read};

fn change(bytes: &mut [u8], changes: &[(Index, u8)]) {
    for (at, value) in changes {
        let at = at.index(bytes.len());
        bytes[at] = *value;
    }
}

/// Every frame is of a depth image. A changed byte may make a message of another topic one that cannot be read.
fn sound(name: &str, bytes: Vec<u8>) -> bool {
    let files = folder(&[(name, bytes)]);
    read(&files.path().join(name)).map_or(true, |(frames, report)| {
        frames.len() as u64 <= report.depth_images && report.depth_images <= messages().len() as u64
    })
}

fn changes() -> impl Strategy<Value = Vec<(Index, u8)>> {
    vec((any::<Index>(), any::<u8>()), 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_sqlite_bags_do_not_panic(changes in changes(), head in any::<bool>(), cut in any::<Index>()) {
        let mut bytes = db3(&messages());
        let end = if head { 2048 } else { bytes.len() };
        change(&mut bytes[..end], &changes);
        bytes.truncate(bytes.len().min(512 + cut.index(2 * bytes.len())));
        prop_assert!(sound("bag.db3", bytes));
    }

    #[test]
    fn changed_packed_files_do_not_panic(changes in changes(), cut in any::<Index>(), message in any::<bool>()) {
        let mut messages = messages();
        if message {
            messages = messages.into_iter().map(Message::packed).collect();
            let at = cut.index(messages.len());
            change(&mut messages[at].data, &changes);
            prop_assert!(sound("bag.mcap", mcap(&messages)));
        } else {
            let mut bytes = zstd::encode_all(&mcap(&messages)[..], 1).unwrap();
            change(&mut bytes, &changes);
            bytes.truncate(4 + cut.index(bytes.len()));
            prop_assert!(sound("bag.mcap.zstd", bytes));
        }
    }

    #[test]
    fn changed_metadata_does_not_panic(changes in changes()) {
        let mut text = metadata(&["a.mcap", "b.mcap"]).into_bytes();
        change(&mut text, &changes);
        let files = folder(&[("a.mcap", mcap(&messages())), ("b.mcap", mcap(&messages())), ("metadata.yaml", text)]);
        // Both names have no number: without metadata they are two recordings.
        prop_assert!(read(files.path()).map_or(true, |(frames, _)| frames.len() >= usize::from(FRAMES)));
    }
}
