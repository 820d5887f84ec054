//! What a YAML or JSON reader says, in the words of a user: one line, the nearest key in place of all keys.

/// The text of a reader's error, for a user: where a key is unknown, its line and the nearest one that is known, else the
/// text as it is, without what concerns programmers.
pub(crate) fn plain(error: &impl ToString) -> String {
    let text = error.to_string();
    unknown_key(&text).unwrap_or_else(|| {
        [
            (", set DuplicateKeyPolicy in Options if acceptable", ""),
            ("expected f64", "expected a number"),
            ("expected f32", "expected a number"),
            ("expected u32", "expected a whole number from 0 up"),
            ("expected u64", "expected a whole number from 0 up"),
            ("expected usize", "expected a whole number from 0 up"),
            ("expected a boolean", "expected true or false"),
            ("expected a sequence", "expected a list: [a, b]"),
            ("expected an array of length", "expected a list of length"),
        ]
        .into_iter()
        .fold(text, |text, (from, to)| text.replace(from, to))
    })
}

/// `unknown field ..., expected one of ...` in short; `None` for other texts.
fn unknown_key(text: &str) -> Option<String> {
    let first_line = text.lines().next()?;
    let (before, rest) = first_line.split_once("unknown field `")?;
    let (key, rest) = rest.split_once('`')?;
    let (_, known) = rest.split_once("expected ")?;
    let known = known.trim_start_matches("one of ").replace(" or ", ",");
    let names = known.split(',').map(|name| name.trim().trim_matches('`')).filter(|name| !name.is_empty());
    let place = before.split_once("line ").and_then(|(_, place)| place.split([' ', ':']).next());
    let place = place.map_or_else(String::new, |line| format!("line {line}: "));
    Some(format!("{place}`{key}` is unknown; the nearest key is `{}`", nearest(key, names)))
}

/// The name most like `key`. A name that holds `key`, or that makes up more than half of it, comes first.
pub(crate) fn nearest<'a>(key: &str, names: impl Iterator<Item = &'a str>) -> &'a str {
    let likeness = |name: &str| {
        let holds = name.contains(key) || (key.contains(name) && 2 * name.len() > key.len());
        strsim::jaro_winkler(key, name) + if holds { 1.0 } else { 0.0 }
    };
    names.max_by(|a, b| likeness(a).total_cmp(&likeness(b))).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_comes_with_the_nearest_alone() {
        for (text, short) in [
            (
                "error: line 60 column 3: unknown field `stepp_m`, expected one of waypoints_m, yaw_rad, step_m\n  --> x",
                "line 60: `stepp_m` is unknown; the nearest key is `step_m`",
            ),
            (
                "unknown field `chidl`, expected one of `parent`, `child`, `translation_m`",
                "`chidl` is unknown; the nearest key is `child`",
            ),
            ("unknown field `dat`, expected `data` or `rows`", "`dat` is unknown; the nearest key is `data`"),
        ] {
            assert_eq!(plain(&text), short);
        }
        assert_eq!(
            plain(&"invalid type: string \"a\", expected f64"),
            "invalid type: string \"a\", expected a number"
        );
        assert_eq!(plain(&"did not find expected node"), "did not find expected node");
    }
}
