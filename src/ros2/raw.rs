//! Messages as they lie in recordings: an encapsulation of four bytes, then CDR. Nothing is decoded on the way.

use std::convert::Infallible;
use std::fmt;

use rustdds::RepresentationIdentifier;
use rustdds::bytes::Bytes;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};

/// Bytes of the encapsulation.
pub(super) const ENCAPSULATION: usize = 4;

/// The encapsulation of little-endian CDR, the only one that is sent.
pub(super) const LITTLE_ENDIAN: [u8; ENCAPSULATION] = [0, 1, 0, 0];

/// See the module.
pub(super) struct Raw;

/// Nothing can go wrong: what the bytes say is for the reader of the message.
#[derive(Debug)]
pub(super) struct Never(Infallible);

impl fmt::Display for Never {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {}
    }
}

impl std::error::Error for Never {}

/// Adds the encapsulation that tells the byte order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encapsulated;

impl Decode<'_, Vec<u8>> for Encapsulated {
    type Error = Never;

    fn decode_bytes(self, body: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, Never> {
        let mut payload = Vec::with_capacity(ENCAPSULATION + body.len());
        payload.extend([0, u8::from(encoding == RepresentationIdentifier::CDR_LE), 0, 0]);
        payload.extend_from_slice(body);
        Ok(payload)
    }
}

impl DeserializerAdapter<Vec<u8>> for Raw {
    type Error = Never;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for Raw {
    type Decoder = Encapsulated;
    const DECODER: Encapsulated = Encapsulated;
}

impl SerializerAdapter<Bytes> for Raw {
    type Error = Never;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(body: &Bytes) -> Result<Bytes, Never> {
        Ok(body.clone())
    }
}
