//! Which node the endpoints of this participant belong to, as `ros2 node list` and `ros2 topic info` ask
//! (`rmw_dds_common/ParticipantEntitiesInfo`).

use serde::Serialize;

use crate::base::Result;
use crate::message::ros2::encode_cdr;
use crate::ros2::environment::Environment;
use crate::ros2::name::Naming;
use crate::ros2::participant::{Participant, Publication};

/// Bytes of an identity up to humble, and since.
const LONG: usize = 24;
const SHORT: usize = 16;

/// A node; identities have `N` bytes.
#[derive(Serialize)]
struct Node<'a, const N: usize>
where
    [u8; N]: Serialize,
{
    namespace: &'a str,
    name: &'a str,
    readers: Vec<[u8; N]>,
    writers: Vec<[u8; N]>,
}

/// See the module.
pub struct Announcement {
    publication: Publication,
    participant: [u8; SHORT],
    long: bool,
    told: (Vec<[u8; SHORT]>, Vec<[u8; SHORT]>),
}

impl Announcement {
    /// # Errors
    /// [`crate::Error::Ros2`] where DDS refuses it.
    pub fn open(participant: &Participant, environment: &Environment) -> Result<Self> {
        Ok(Self {
            publication: participant.publish_nodes()?,
            participant: participant.guid(),
            long: environment.long_gids,
            told: Default::default(),
        })
    }

    /// Tells the identities of the node's readers and writers, unless they are told.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub fn tell(
        &mut self,
        naming: &Naming,
        readers: Vec<[u8; SHORT]>,
        mut writers: Vec<[u8; SHORT]>,
    ) -> Result<()> {
        writers.push(self.publication.guid());
        if self.told == (readers.clone(), writers.clone()) {
            return Ok(());
        }
        let payload = if self.long {
            encode::<LONG>(&self.participant, naming, &readers, &writers)?
        } else {
            encode::<SHORT>(&self.participant, naming, &readers, &writers)?
        };
        self.publication.send(payload)?;
        self.told = (readers, writers);
        Ok(())
    }
}

fn encode<const N: usize>(
    participant: &[u8; SHORT],
    naming: &Naming,
    readers: &[[u8; SHORT]],
    writers: &[[u8; SHORT]],
) -> Result<Vec<u8>>
where
    [u8; N]: Serialize,
{
    let padded = |gid: &[u8; SHORT]| {
        let mut padded = [0; N];
        padded[..SHORT].copy_from_slice(gid);
        padded
    };
    let node = Node {
        namespace: naming.namespace(),
        name: naming.node(),
        readers: readers.iter().map(padded).collect(),
        writers: writers.iter().map(padded).collect(),
    };
    // The participant, then a sequence of one node.
    let entities = (padded(participant), 1_u32, node);
    encode_cdr("rmw_dds_common/ParticipantEntitiesInfo", &entities)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_those_of_the_definition() {
        let naming = Naming::new("eyes", "/r", &[]).unwrap();
        let short = encode::<SHORT>(&[7; SHORT], &naming, &[[1; SHORT]], &[[2; SHORT], [3; SHORT]]).unwrap();
        let mut expected = vec![0, 1, 0, 0];
        expected.extend([7; 16]);
        expected.extend([1, 0, 0, 0]);
        expected.extend([3, 0, 0, 0, b'/', b'r', 0, 0]);
        expected.extend([5, 0, 0, 0, b'e', b'y', b'e', b's', 0, 0, 0, 0]);
        expected.extend([1, 0, 0, 0]);
        expected.extend([1; 16]);
        expected.extend([2, 0, 0, 0]);
        expected.extend([2; 16].into_iter().chain([3; 16]));
        assert_eq!(short, expected);
        let long = encode::<LONG>(&[7; SHORT], &naming, &[], &[]).unwrap();
        assert_eq!(&long[4..28], &[&[7_u8; 16][..], &[0; 8]].concat()[..]);
    }
}
