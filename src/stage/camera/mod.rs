//! The stages of an RGB-D frame (spec 1).

pub mod align_color;
pub mod back_project;
pub(crate) mod color;
pub mod drm;
pub mod ingest;
pub mod map_reliability;
pub mod pane_clip;
pub mod register_color;
pub mod see_through;
pub mod spatial_median;
pub mod tally;
pub mod update;
pub mod view;
pub mod weigh;
