//! The little of zip that captures need: the central directory, and members as one stream.
//!
//! Written here, not taken from a crate, for three reasons: the memory for the directory has a
//! bound, several members are read side by side, and an error names the member and the byte.
//! Inflating and CRC-32 are `flate2` and `crc32fast`.

use std::io::{BufReader, Read, Take};

use flate2::bufread::DeflateDecoder;

use crate::Format;
use crate::error::{CaptureError, Place};
use crate::input::{Bytes, Fields, Input};

/// Members that may be kept; at 4 MiB a chunk that is 256 GiB of samples.
const MAX_MEMBERS: usize = 65_536;
/// Longer names belong to no capture.
const MAX_NAME: usize = 256;
/// A text member (`metadata`, `header`) is read whole.
const MAX_TEXT: u64 = 256 * 1024;

const END: [u8; 4] = *b"PK\x05\x06";
const END_LEN: usize = 22;
const END64_LOCATOR: [u8; 4] = *b"PK\x06\x07";
const END64: [u8; 4] = *b"PK\x06\x06";
const CENTRAL: [u8; 4] = *b"PK\x01\x02";
pub(crate) const LOCAL: [u8; 4] = *b"PK\x03\x04";

/// One member of the archive.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) name: Box<str>,
    pub(crate) size: u64,
    compressed: u64,
    offset: u64,
    crc: u32,
    method: u16,
    encrypted: bool,
}

/// The members of an archive that the caller finds interesting.
pub(crate) struct Archive {
    input: Input,
    format: Format,
    pub(crate) entries: Vec<Entry>,
}

impl Archive {
    /// Reads the central directory and keeps the members that `wanted` names.
    pub(crate) fn open(
        input: &Input,
        format: Format,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Self, CaptureError> {
        let (offset, count) = find_directory(input)?;
        let reader = BufReader::with_capacity(64 * 1024, input.at(offset));
        let mut fields = Fields::new(reader, offset);
        let mut entries = Vec::new();
        for _ in 0..count {
            let Some(entry) = read_entry(&mut fields)? else { continue };
            if !wanted(&entry.name) {
                continue;
            }
            if entries.len() >= MAX_MEMBERS {
                return Err(CaptureError::Limit {
                    what: "the number of members",
                    value: count,
                    max: MAX_MEMBERS as u64,
                });
            }
            entries.push(entry);
        }
        Ok(Self { input: input.clone(), format, entries })
    }

    pub(crate) fn find(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| &*entry.name == name)
    }

    /// A text member, whole.
    pub(crate) fn text(&self, name: &str) -> Result<Option<String>, CaptureError> {
        let Some(entry) = self.find(name) else { return Ok(None) };
        if entry.size > MAX_TEXT {
            return Err(CaptureError::Limit {
                what: "the size of a text member",
                value: entry.size,
                max: MAX_TEXT,
            });
        }
        let mut chain = self.chain(vec![entry.clone()]);
        let mut text = Vec::new();
        let mut buffer = [0; 4096];
        loop {
            let n = chain.read_some(&mut buffer)?;
            if n == 0 {
                return Ok(Some(String::from_utf8_lossy(&text).into_owned()));
            }
            text.extend_from_slice(buffer.get(..n).unwrap_or_default());
        }
    }

    /// The contents of `entries`, one after the other.
    pub(crate) fn chain(&self, entries: Vec<Entry>) -> Chain {
        Chain {
            input: self.input.clone(),
            format: self.format,
            entries: entries.into_iter(),
            member: None,
        }
    }
}

/// Offset of the central directory and the number of its entries.
fn find_directory(input: &Input) -> Result<(u64, u64), CaptureError> {
    let tail_len =
        (END_LEN + usize::from(u16::MAX)).min(usize::try_from(input.len()).unwrap_or(usize::MAX));
    let tail_at = input.len() - tail_len as u64;
    let tail = input.bytes(tail_at, tail_len)?;
    let no_end = || {
        CaptureError::damaged(
            Place::Byte(input.len()),
            "the zip directory at the end is missing: the file is cut short",
        )
    };
    let at = memchr::memmem::rfind(&tail, &END).ok_or_else(no_end)?;
    let end_at = tail_at + at as u64;
    let mut fields = Fields::new(tail.get(at + 4..).unwrap_or_default(), end_at + 4);
    fields.array::<6>()?;
    let count = u16::from_le_bytes(fields.array()?);
    fields.u32()?;
    let offset = fields.u32()?;
    if count != u16::MAX && offset != u32::MAX {
        return Ok((u64::from(offset), u64::from(count)));
    }
    let Some(locator_at) = end_at.checked_sub(20) else {
        return Ok((u64::from(offset), u64::from(count)));
    };
    let mut locator = Fields::new(input.at(locator_at), locator_at);
    if locator.array::<4>()? != END64_LOCATOR {
        return Ok((u64::from(offset), u64::from(count)));
    }
    locator.u32()?;
    let end64_at = locator.u64()?;
    let mut end64 = Fields::new(input.at(end64_at), end64_at);
    if end64.array::<4>()? != END64 {
        return Err(CaptureError::damaged(Place::Byte(end64_at), "no zip64 directory end here"));
    }
    end64.array::<28>()?;
    let count = end64.u64()?;
    end64.u64()?;
    Ok((end64.u64()?, count))
}

/// One record of the central directory; `None` for one that no capture has.
fn read_entry(fields: &mut Fields<impl Read>) -> Result<Option<Entry>, CaptureError> {
    let place = fields.place();
    if fields.array::<4>()? != CENTRAL {
        return Err(CaptureError::damaged(place, "no zip directory entry here"));
    }
    fields.u32()?;
    let flags = u16::from_le_bytes(fields.array()?);
    let method = u16::from_le_bytes(fields.array()?);
    fields.u32()?;
    let crc = fields.u32()?;
    let mut compressed = u64::from(fields.u32()?);
    let mut size = u64::from(fields.u32()?);
    let [name_len, extra_len, comment_len] = [fields.array()?, fields.array()?, fields.array()?]
        .map(|b| usize::from(u16::from_le_bytes(b)));
    fields.array::<8>()?;
    let mut offset = u64::from(fields.u32()?);
    let name = take(fields, name_len)?;
    let extra = take(fields, extra_len)?;
    take(fields, comment_len)?;
    widen(&extra, &mut [&mut size, &mut compressed, &mut offset]);
    if name_len > MAX_NAME {
        return Ok(None);
    }
    let name = String::from_utf8_lossy(&name).into_owned().into_boxed_str();
    Ok(Some(Entry { name, size, compressed, offset, crc, method, encrypted: flags & 1 == 1 }))
}

fn take(fields: &mut Fields<impl Read>, len: usize) -> Result<Vec<u8>, CaptureError> {
    let mut bytes = vec![0; len];
    if fields.block(&mut bytes)? < len {
        return Err(CaptureError::damaged(fields.place(), "the file ends too early"));
    }
    Ok(bytes)
}

/// Replaces the values that the zip64 extra field (id 1) carries in full.
fn widen(extra: &[u8], values: &mut [&mut u64]) {
    let mut rest = extra;
    while let [a, b, c, d, body @ ..] = rest {
        let len = usize::from(u16::from_le_bytes([*c, *d])).min(body.len());
        let (field, next) = body.split_at(len);
        if u16::from_le_bytes([*a, *b]) == 1 {
            let (wide, _) = field.as_chunks::<8>();
            let narrow = values.iter_mut().filter(|value| ***value == u64::from(u32::MAX));
            for (value, bytes) in narrow.zip(wide) {
                **value = u64::from_le_bytes(*bytes);
            }
            return;
        }
        rest = next;
    }
}

enum Content {
    Stored(Take<BufReader<Input>>),
    Deflated(DeflateDecoder<Take<BufReader<Input>>>),
}

struct Member {
    entry: Entry,
    content: Content,
    done: u64,
    crc: crc32fast::Hasher,
}

/// Several members read as one stream; sizes and CRC-32 are checked on the way.
pub(crate) struct Chain {
    input: Input,
    format: Format,
    entries: std::vec::IntoIter<Entry>,
    member: Option<Member>,
}

impl Chain {
    fn start(&self, entry: Entry) -> Result<Member, CaptureError> {
        let place = || Place::Member(entry.name.to_string());
        if entry.encrypted {
            return Err(CaptureError::damaged(place(), "is encrypted"));
        }
        let mut fields = Fields::new(self.input.at(entry.offset), entry.offset);
        if fields.array::<4>()? != LOCAL {
            return Err(CaptureError::damaged(place(), "the directory points to no member"));
        }
        fields.array::<22>()?;
        let name_len = u64::from(u16::from_le_bytes(fields.array()?));
        let extra_len = u64::from(u16::from_le_bytes(fields.array()?));
        let start = entry.offset.saturating_add(30 + name_len + extra_len);
        let raw = BufReader::with_capacity(64 * 1024, self.input.at(start)).take(entry.compressed);
        let content = match entry.method {
            0 => Content::Stored(raw),
            8 => Content::Deflated(DeflateDecoder::new(raw)),
            other => {
                return Err(CaptureError::unsupported(
                    self.format,
                    format!(
                        "member {:?} uses zip method {other} (stored and deflate are read)",
                        entry.name
                    ),
                ));
            }
        };
        Ok(Member { entry, content, done: 0, crc: crc32fast::Hasher::new() })
    }
}

impl Bytes for Chain {
    fn read_some(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError> {
        loop {
            let member = match &mut self.member {
                Some(member) => member,
                None => {
                    let Some(entry) = self.entries.next() else { return Ok(0) };
                    self.member = Some(self.start(entry)?);
                    continue;
                }
            };
            let n = member.read(buf)?;
            if n > 0 {
                return Ok(n);
            }
            self.member = None;
        }
    }
}

impl Member {
    fn read(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError> {
        let result = loop {
            let result = match &mut self.content {
                Content::Stored(raw) => raw.read(buf),
                Content::Deflated(inflated) => inflated.read(buf),
            };
            match result {
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                result => break result,
            }
        };
        let place = |at| Place::MemberByte(self.entry.name.to_string(), at);
        let n = result.map_err(|e| match e.kind() {
            std::io::ErrorKind::InvalidInput
            | std::io::ErrorKind::InvalidData
            | std::io::ErrorKind::UnexpectedEof => {
                CaptureError::damaged(place(self.done), format!("cannot be inflated: {e}"))
            }
            _ => CaptureError::Read { place: place(self.done), source: e },
        })?;
        self.crc.update(buf.get(..n).unwrap_or_default());
        self.done += n as u64;
        if self.done > self.entry.size || (n == 0 && self.done < self.entry.size) {
            let reason = format!("has another size than its directory entry ({})", self.entry.size);
            return Err(CaptureError::damaged(place(self.done), reason));
        }
        if n == 0 && self.crc.clone().finalize() != self.entry.crc {
            return Err(CaptureError::damaged(place(self.done), "CRC-32 does not match"));
        }
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_values_that_do_not_fit_are_taken_from_the_zip64_field() {
        // A foreign field, then the zip64 one with two values.
        let mut extra = vec![9, 0, 2, 0, 0xaa, 0xbb, 1, 0, 16, 0];
        extra.extend(5_000_000_000_u64.to_le_bytes());
        extra.extend(7_000_000_000_u64.to_le_bytes());
        let (mut size, mut compressed, mut offset) = (0xffff_ffff, 12, 0xffff_ffff);
        widen(&extra, &mut [&mut size, &mut compressed, &mut offset]);
        assert_eq!((size, compressed, offset), (5_000_000_000, 12, 7_000_000_000));
        // Cut short: what is there counts.
        let mut size = 0xffff_ffff;
        widen(&[1, 0, 16, 0, 1, 2], &mut [&mut size]);
        assert_eq!(size, 0xffff_ffff);
    }
}
