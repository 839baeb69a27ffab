//! What format a file has, from its content.

use crate::Format;
use crate::error::CaptureError;
use crate::input::Input;
use crate::zip::{self, Archive};
use crate::{csv, dsview, isf, logicdata, saleae, sr};

/// Bytes of the head that are looked at.
const HEAD: usize = 64 * 1024;

pub(crate) fn sniff(input: &Input) -> Result<Format, CaptureError> {
    let head = input.bytes(0, HEAD)?;
    if head.starts_with(&zip::LOCAL) {
        return sniff_zip(input);
    }
    if head.starts_with(&saleae::binary::MAGIC) {
        return Ok(Format::SaleaeBinary);
    }
    if head.first() == Some(&logicdata::MAGIC)
        && memchr::memmem::find(head.get(..32).unwrap_or(&head), b"Data save").is_some()
    {
        return Ok(Format::LogicData);
    }
    if isf::sniff(&head) {
        return Ok(Format::TekIsf);
    }
    if let Some(word) = saleae::logic1::sniff_changes(&head, input.len()) {
        return Ok(Format::Logic1Changes(word));
    }
    if head.trim_ascii_start().starts_with(b"$") {
        return Ok(Format::Vcd);
    }
    match csv::sniff(input)? {
        Some(header) => Ok(header.format),
        None => Err(CaptureError::Unrecognised(describe(&head))),
    }
}

fn sniff_zip(input: &Input) -> Result<Format, CaptureError> {
    let is_mark = |name: &str| matches!(name, "version" | "metadata" | "header");
    let archive = Archive::open(input, Format::SigrokSr, is_mark)?;
    let names: Vec<&str> = archive.entries.iter().map(|e| &*e.name).collect();
    if sr::is_sr(&names) {
        return Ok(Format::SigrokSr);
    }
    if dsview::is_dsview(&names) {
        return Ok(Format::DsView);
    }
    Err(CaptureError::Unrecognised("a zip archive without the members of a capture".into()))
}

fn describe(head: &[u8]) -> String {
    let start: String = head
        .iter()
        .take(16)
        .flat_map(|&b| core::ascii::escape_default(b))
        .map(char::from)
        .collect();
    format!(
        "it starts with \"{start}\"; Logic 1 exports without a header need their format, such as logic1-8"
    )
}
