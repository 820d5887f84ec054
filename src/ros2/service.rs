//! Services: requests come in by the inbox, replies go out by name of who asked. Which request a reply answers is told in two
//! ways, by the implementation of DDS that asks: Cyclone's RMW has a header of 16 bytes in front of every request and reply; others have
//! the request's identity beside the reply (DDS-RPC's "enhanced" mapping).

use rustdds::no_key::DataWriter;
use rustdds::rpc::SampleIdentity;
use rustdds::{GUID, RTPSEntity, SequenceNumber, Timestamp, WriteOptionsBuilder};

use crate::base::Result;
use crate::message::decode_error;
use crate::ros2::participant::{Participant, Subscription};
use crate::ros2::qos::Quality;
use crate::ros2::raw::{ENCAPSULATION, LITTLE_ENDIAN, Raw};
use crate::ros2::{Bytes, ros2_error};

/// How services are asked and answered (`rmw_qos_profile_services_default`).
const QUALITY: Quality = Quality::Stream { depth: 10 };

/// First bytes of the identity of whatever Cyclone DDS makes.
const CYCLONE: [u8; 2] = [0x01, 0x10];

/// Bytes of the header of Cyclone's RMW: half of the client's identity, and the number of the request.
const HEADER: usize = 16;

/// Which writer sent a message, and under which number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Origin {
    /// Identity of the writer.
    pub writer: [u8; 16],
    /// Its number of the message, from 1.
    pub number: i64,
}

/// What a reply needs of its request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asker {
    origin: Origin,
    header: Option<[u8; HEADER]>,
}

impl Asker {
    /// Takes a request apart: who asks, and the request itself, its encapsulation in front.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] for one that is too short for its header.
    pub fn of(origin: Origin, payload: &[u8]) -> Result<(Self, Vec<u8>)> {
        if origin.writer[..2] != CYCLONE {
            return Ok((Self { origin, header: None }, payload.to_vec()));
        }
        let parts = payload.split_at_checked(ENCAPSULATION);
        let parts = parts.and_then(|(start, body)| Some((start, body.split_first_chunk::<HEADER>()?)));
        let Some((start, (header, body))) = parts else {
            return Err(decode_error("request", "it is too short for its header"));
        };
        let mut header = *header;
        if start[..2] != LITTLE_ENDIAN[..2] {
            header.chunks_exact_mut(8).for_each(<[u8]>::reverse);
        }
        // The header has a multiple of eight bytes: what follows is aligned as without it.
        Ok((Self { origin, header: Some(header) }, [start, body].concat()))
    }
}

/// The replies of a service.
pub struct Replies {
    name: String,
    writer: DataWriter<Bytes, Raw>,
}

impl Replies {
    /// Identity of the writer.
    pub fn guid(&self) -> [u8; 16] {
        self.writer.guid().to_bytes()
    }

    /// Sends the reply to a request, its encapsulation in front.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub fn send(&self, to: &Asker, payload: &[u8]) -> Result<()> {
        let body = payload.get(ENCAPSULATION..).unwrap_or_default();
        let body = match &to.header {
            Some(header) => [header, body].concat(),
            None => body.to_vec(),
        };
        let asked = SampleIdentity {
            writer_guid: GUID::from_bytes(to.origin.writer),
            sequence_number: SequenceNumber::from(to.origin.number),
        };
        let options = WriteOptionsBuilder::new()
            .source_timestamp(Timestamp::now())
            .related_sample_identity(asked)
            .build();
        let sent = self.writer.write_with_options(body.into(), options);
        sent.map(drop).map_err(|error| ros2_error(&self.name, error))
    }
}

impl Participant {
    /// Serves a service of that full name; `type_name` as in `std_srvs/srv/Trigger`. Requests, and what answers them.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] where DDS refuses it.
    pub fn serve(&self, name: &str, type_name: &str) -> Result<(Subscription, Replies)> {
        let [package, "srv", kind] = type_name.split('/').collect::<Vec<_>>()[..] else {
            let reason = format!("`{type_name}` is not a service type (package/srv/Name)");
            return Err(ros2_error(name, reason));
        };
        let half = |half: &str| format!("{package}::srv::dds_::{kind}_{half}_");
        let requests =
            self.subscribe_raw(&format!("rq{name}Request"), half("Request"), &QUALITY.of_reader())?;
        let writer = self.publish_raw(&format!("rr{name}Reply"), half("Response"), QUALITY.of_writer())?;
        Ok((requests, Replies { name: name.into(), writer }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_of_cyclone_has_a_header_that_goes_back() {
        let origin =
            Origin { writer: [[1, 0x10].as_slice(), &[7; 14]].concat().try_into().unwrap(), number: 3 };
        let header: [u8; HEADER] = *b"\x00\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0a\x0b\x0c\x0d\x0e\x0f";
        let payload = [&[0, 1, 0, 0][..], &header, &[42]].concat();
        let (asker, request) = Asker::of(origin, &payload).unwrap();
        assert_eq!((request, asker.header), (vec![0, 1, 0, 0, 42], Some(header)));
        let (big, _) = Asker::of(origin, &[&[0, 0, 0, 0][..], &header].concat()).unwrap();
        assert_eq!(big.header.unwrap()[..3], [7, 6, 5]);
        for short in [&payload[..3], &payload[..19], &[]] {
            assert!(Asker::of(origin, short).is_err());
        }
        let other = Origin { writer: [1; 16], number: 3 };
        let (asker, request) = Asker::of(other, &payload).unwrap();
        assert_eq!((request, asker.header), (payload, None));
    }
}
