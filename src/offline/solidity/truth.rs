//! What stands in a cell.

use glam::{DVec2, DVec3};

use crate::map::Grid;
use crate::sim::Scene;
use crate::sim::lidar::PointTruth;
use crate::sim::truth::OCCUPIED;

/// By its points, and by the true map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Label {
    /// Something that a robot cannot pass, other than glass.
    Solid = 0,
    /// All points are of what a robot passes, and nothing else stands in the cell.
    Passable = 1,
    /// All points are of glass.
    Glass = 2,
    /// All points are mirror images.
    Image = 3,
    /// All points are of what a robot passes, but something solid stands in the cell too.
    Edge = 4,
}

/// Points of a cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Votes {
    solid: u32,
    passable: u32,
    glass: u32,
    images: u32,
    materials: Vec<(u8, u32)>,
}

impl Votes {
    pub(super) fn add(&mut self, truth: &PointTruth) {
        match (truth.is_reflection(), truth.is_glass(), truth.is_passable()) {
            (true, ..) => self.images += 1,
            (_, true, _) => self.glass += 1,
            (.., true) => self.passable += 1,
            _ => self.solid += 1,
        }
        match self.materials.iter_mut().find(|(known, _)| *known == truth.material) {
            Some((_, count)) => *count += 1,
            None => self.materials.push((truth.material, 1)),
        }
    }

    /// How many.
    pub(super) fn points(&self) -> u32 {
        self.solid + self.passable + self.glass + self.images
    }

    /// `true_cell`: what the true map says; `None` without points.
    pub(super) fn label(&self, true_cell: Option<i8>) -> Option<Label> {
        let edge = true_cell == Some(OCCUPIED);
        match (self.solid, self.passable, self.glass, self.images) {
            (0, 0, 0, 0) => None,
            (0, 0, 0, _) => Some(Label::Image),
            (0, 0, ..) => Some(Label::Glass),
            (0, ..) if edge => Some(Label::Edge),
            (0, _, 0, _) => Some(Label::Passable),
            _ => Some(Label::Solid),
        }
    }

    /// The material of most points.
    pub(super) fn material(&self, scene: &Scene) -> String {
        let most = self.materials.iter().max_by_key(|(_, count)| *count).map(|(number, _)| *number);
        let name = most.and_then(|number| scene.materials.keys().nth(number.into()));
        name.cloned().unwrap_or_else(|| "light".into())
    }
}

/// The true map's word for a place.
pub(super) fn true_cell(grid: &Grid, cells: &[i8], at: DVec2) -> Option<i8> {
    super::cell_at(grid, DVec3::new(at.x, at.y, 0.0)).and_then(|cell| cells.get(cell)).copied()
}
