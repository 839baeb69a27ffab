//! A document with sections that programs write: each between `<!-- generated: NAME -->` and
//! `<!-- end -->`, everything else by hand.

use anyhow::{Context, Result, bail};

const END: &str = "<!-- end -->";

fn begin(name: &str) -> String {
    format!("<!-- generated: {name} -->")
}

/// Where the body of section `name` is: after the line that begins it, before the one that ends it.
fn place(text: &str, name: &str) -> Result<core::ops::Range<usize>> {
    let begin = begin(name);
    let mut found = text.match_indices(&begin);
    let (at, _) = found.next().with_context(|| format!("there is no \"{begin}\""))?;
    if found.next().is_some() {
        bail!("\"{begin}\" is there twice");
    }
    let from = at + begin.len();
    let length =
        text[from..].find(END).with_context(|| format!("no \"{END}\" after \"{begin}\""))?;
    if text[from..from + length].contains("<!-- generated:") {
        bail!("no \"{END}\" after \"{begin}\"");
    }
    Ok(from..from + length)
}

/// What stands in section `name`, without the blank lines around it.
///
/// # Errors
/// If the section is absent, there twice, or has no end.
pub fn section<'a>(text: &'a str, name: &str) -> Result<&'a str> {
    Ok(text[place(text, name)?].trim_matches('\n'))
}

/// `text` with `body` in section `name`.
///
/// # Errors
/// As [`section`].
pub fn with_section(text: &str, name: &str, body: &str) -> Result<String> {
    let place = place(text, name)?;
    let body = body.trim_matches('\n');
    Ok(format!("{}\n\n{body}\n\n{}", &text[..place.start], &text[place.end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A\n<!-- generated: one -->\nold\n<!-- end -->\nby hand\n\
                        <!-- generated: two -->\n<!-- end -->\n";

    #[test]
    fn section_is_replaced_and_nothing_else() {
        let text = with_section(TEXT, "one", "new\nlines").unwrap();
        assert_eq!(section(&text, "one").unwrap(), "new\nlines");
        assert_eq!(section(&text, "two").unwrap(), "");
        assert!(text.starts_with("# A\n<!--") && text.contains("-->\nby hand\n<!--"), "{text}");
        // What is up to date stays as it is.
        assert_eq!(with_section(&text, "one", "new\nlines").unwrap(), text);
    }

    #[test]
    fn missing_and_broken_sections_are_named() {
        let error = |text: &str, name: &str| section(text, name).unwrap_err().to_string();
        assert!(error(TEXT, "three").contains("generated: three"));
        assert!(error("<!-- generated: a -->\n", "a").contains("no \"<!-- end -->\""));
        let open = "<!-- generated: a -->\n<!-- generated: b -->\n<!-- end -->\n";
        assert!(error(open, "a").contains("no \"<!-- end -->\""));
        let twice = format!("{TEXT}{TEXT}");
        assert!(error(&twice, "one").contains("twice"));
    }
}
