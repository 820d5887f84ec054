//! A YAML file as a tree of sections and values that knows its lines.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use serde_saphyr::Spanned;
use serde_saphyr::options::NonFiniteFloatPolicy;

use super::bad_key;
use crate::base::{Error, Result, plain};

/// A key with what stands behind it.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) line: u64,
    pub(super) node: Node,
}

#[derive(Debug)]
pub(super) enum Node {
    /// A mapping.
    Section(Vec<Entry>),
    /// A scalar or a list.
    Value(Value),
    /// A number that JSON does not have.
    NotFinite(f64),
}

impl Entry {
    /// An error about this key; `name` is the key with its section.
    pub(super) fn fault(&self, name: &str, reason: impl fmt::Display) -> Error {
        bad_key(name, format!("{reason} (line {})", self.line))
    }
}

/// The entries at the file's root; none where it holds comments alone.
pub(super) fn read(text: &str) -> Result<Vec<Entry>> {
    let unwritten = |line: &str| line.trim().is_empty() || line.trim().starts_with('#');
    if text.lines().all(unwritten) {
        return Ok(Vec::new());
    }
    // The key of a number that is not finite is named further on, as that of any other impossible value.
    let options = serde_saphyr::options! { non_finite_float_policy: NonFiniteFloatPolicy::PassThrough };
    match serde_saphyr::from_str_with_options(text, options).map_err(|error| Error::Yaml(plain(&error)))? {
        Node::Section(entries) => Ok(entries),
        Node::Value(Value::Null) => Ok(Vec::new()),
        _ => Err(Error::Yaml("the file holds no keys: `key: value` lines are needed".into())),
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value or a section")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Node, A::Error> {
        let mut entries = Vec::new();
        while let Some(key) = map.next_key::<Spanned<String>>()? {
            let line = key.referenced.line();
            entries.push(Entry { key: key.value, line, node: map.next_value()? });
        }
        Ok(Node::Section(entries))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<Node, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(Node::Value(Value::Array(values)))
    }

    fn visit_unit<E>(self) -> std::result::Result<Node, E> {
        Ok(Node::Value(Value::Null))
    }

    fn visit_none<E>(self) -> std::result::Result<Node, E> {
        Ok(Node::Value(Value::Null))
    }

    fn visit_bool<E>(self, value: bool) -> std::result::Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<Node, E> {
        Ok(if value.is_finite() { Node::Value(value.into()) } else { Node::NotFinite(value) })
    }

    fn visit_str<E>(self, value: &str) -> std::result::Result<Node, E> {
        Ok(Node::Value(value.into()))
    }
}
