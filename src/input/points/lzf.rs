//! LZF, the compression of `binary_compressed` PCD files.

/// The bytes in `packed`; `None` where they are not `size` bytes. Allocates as bytes come, never by `size` alone.
///
/// A control byte below 32 says how many bytes follow as they are; others repeat bytes that came before: the upper three
/// bits give the length (7: and the next byte), the lower five and a byte the distance.
pub(super) fn decompress(packed: &[u8], size: usize) -> Option<Vec<u8>> {
    let (mut out, mut rest) = (Vec::new(), packed);
    while let Some((&control, after)) = rest.split_first() {
        if control < 32 {
            let (plain, after) = after.split_at_checked(usize::from(control) + 1)?;
            out.extend_from_slice(plain);
            rest = after;
        } else {
            let (more, after) = match control >> 5 {
                7 => after.split_first().map(|(&more, after)| (more, after))?,
                _ => (0, after),
            };
            let (&low, after) = after.split_first()?;
            let length = usize::from(control >> 5) + usize::from(more) + 2;
            let distance = (usize::from(control & 31) << 8) + usize::from(low) + 1;
            let start = out.len().checked_sub(distance)?;
            // What is repeated may overlap what is written.
            for at in start..start + length {
                out.push(out[at]);
            }
            rest = after;
        }
        if out.len() > size {
            return None;
        }
    }
    (out.len() == size).then_some(out)
}
