//! Groups of solids that lie together, so that rays which pass by a group need not look at its members.

use glam::DVec3;

/// The kinds of solids that shaders keep in tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Table {
    Quad,
    Box,
    Cylinder,
    /// A vessel is a group of its own.
    Vessel,
}

/// A solid by its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Item {
    /// Where it is kept.
    pub(crate) table: Table,
    /// Its number among the scene's solids of that kind.
    pub(crate) index: usize,
    /// Whether it casts a shadow.
    pub(crate) casts: bool,
    /// Least corner, metres.
    pub(crate) low: DVec3,
    /// Greatest corner, metres.
    pub(crate) high: DVec3,
}

/// Solids of a group; more are split.
const MOST: usize = 4;

/// Splits the items in halves along their widest axis until groups are small.
pub(crate) fn clusters(items: Vec<Item>) -> Vec<Vec<Item>> {
    if items.len() <= MOST {
        return if items.is_empty() { vec![] } else { vec![items] };
    }
    let centers = items.iter().map(|item| item.low + item.high);
    let low = centers.clone().fold(DVec3::INFINITY, DVec3::min);
    let high = centers.fold(DVec3::NEG_INFINITY, DVec3::max);
    let axis = (high - low).max_position();
    let mut items = items;
    items.sort_by(|a, b| (a.low + a.high)[axis].total_cmp(&(b.low + b.high)[axis]));
    let rest = items.split_off(items.len() / 2);
    clusters(items).into_iter().chain(clusters(rest)).collect()
}

/// The bounds of a group, a little wider for rounding.
pub(crate) fn bounds(items: &[Item]) -> (DVec3, DVec3) {
    const WIDER_M: f64 = 1e-3;
    let low = items.iter().map(|item| item.low).fold(DVec3::INFINITY, DVec3::min);
    let high = items.iter().map(|item| item.high).fold(DVec3::NEG_INFINITY, DVec3::max);
    (low - WIDER_M, high + WIDER_M)
}
