//! The rule of the map (spec 4 §2): from what its layers say of a cell to a verdict. The table is data; the shader's text, the
//! documentation and the tests come from it.
//!
//! | # | panes | lidar | camera | verdict | cost |
//! |---|---|---|---|---|---|
//! | 1 | pane | any | any | glass | 254 |
//! | 2 | none | solid | any | solid | 254 |
//! | 3 | none | transparent | any | transparent | 254 |
//! | 4 | none | passable | occupied | occupied, or passable with `passable_over_camera` | 254, or the passable cost with `passable_over_camera` |
//! | 5 | none | free where the hits are, and newer | occupied and doubtful, or occupied with `lidar_clears_camera: always` | refuted | 0 |
//! | 6 | none | any | occupied | occupied | 254 |
//! | 7 | none | passable | unknown or free | passable | the passable cost |
//! | 8 | none | free | unknown or free | free | 0 |
//! | 9 | none | unknown | free | free | 0 |
//! | 10 | none | unknown | unknown | unknown | 255 |
//! | 11 | any verdict of free or passable whose evidence is stale | | | stale | 255 |
//! | 12 | any verdict that is not lethal, where the ground drops away | | | drop | 254 |
//! | 13 | unknown, stale, or free by a camera, between two cells occupied by cameras that face each other (`fusion: evidence` and `learned`) | | | bridged | 254 |
//!
//! With `lidar_clears_camera: never` row 5 never applies.

use std::fmt::Write as _;

use crate::config::{Config, LidarClearsCamera};

/// What the panes say, as one bit.
pub mod panes {
    /// No pane crosses the cell.
    pub const NONE: u32 = 1;
    /// One does.
    pub const PANE: u32 = 2;
}

/// What the lidars say, as bits: one of the first five, and `REFUTING` beside `FREE`.
pub mod lidar {
    /// Nothing.
    pub const UNKNOWN: u32 = 1;
    /// Beams crossed the cell, and none ended in it.
    pub const FREE: u32 = 2;
    /// Returns, but weak ones.
    pub const PASSABLE: u32 = 4;
    /// Glass, seen by the horizontal plane alone.
    pub const TRANSPARENT: u32 = 8;
    /// In the way.
    pub const SOLID: u32 = 16;
    /// Free where the camera's hits are, newer than they are.
    pub const REFUTING: u32 = 32;
}

/// What the cameras say, as bits: one of the first three, and `DOUBTFUL` beside `OCCUPIED`.
pub mod camera {
    /// Nothing, or too little.
    pub const UNKNOWN: u32 = 1;
    /// Seen through.
    pub const FREE: u32 = 2;
    /// In the way.
    pub const OCCUPIED: u32 = 4;
    /// Occupied by weak evidence.
    pub const DOUBTFUL: u32 = 8;
}

const ANY: u32 = 63;

/// Lidar state of each class of a cell, by the number of the class (`shaders/lib/scan.wgsl`).
pub const CLASS_STATES: [u32; 5] =
    [lidar::UNKNOWN, lidar::FREE, lidar::SOLID, lidar::PASSABLE, lidar::TRANSPARENT];

/// Camera state of each state of a cell, by its number (`shaders/lib/cell.wgsl`).
pub const CELL_STATES: [u32; 3] = [camera::UNKNOWN, camera::FREE, camera::OCCUPIED];

/// Mean R of the last hit under which a cell is doubtful, in 1/255: 0.6.
pub const DOUBTFUL_BELOW: u32 = 153;

/// How near the lowest and the highest hit a beam must have crossed to refute them, metres.
pub const REFUTING_WITHIN_M: f64 = 0.03;

/// How far apart the beams between them may be, metres.
pub const REFUTING_GAP_M: f64 = 0.1;

/// The row of stale cells.
pub const STALE_ROW: u32 = 11;

/// The row of cells in which the ground drops away.
pub const DROP_ROW: u32 = 12;

/// The row of gaps between occupied cells (spec 1 §9, step 7).
pub const BRIDGED_ROW: u32 = 13;

/// What a configuration decides of the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RuleSettings {
    /// Cost of passable cells, 0 to 252.
    pub passable_cost: u32,
    /// Whether a cell that a lidar calls passable is so where a camera calls it occupied (row 4).
    pub passable_over_camera: bool,
    /// Which occupied cells a lidar refutes (row 5).
    pub lidar_clears_camera: LidarClearsCamera,
}

impl RuleSettings {
    /// Those of a configuration.
    pub fn of(config: &Config) -> Self {
        Self {
            passable_cost: config.passable_cost,
            passable_over_camera: config.passable_over_camera,
            lidar_clears_camera: config.lidar_clears_camera,
        }
    }
}

impl Default for RuleSettings {
    fn default() -> Self {
        Self::of(&Config::default())
    }
}

/// Cost of a verdict before inflation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    /// 254.
    Lethal,
    /// The passable cost.
    Passable,
    /// 0.
    Free,
    /// 255.
    Unknown,
}

impl Cost {
    /// In Nav2's scale.
    pub fn value(self, settings: &RuleSettings) -> u32 {
        match self {
            Self::Lethal => 254,
            Self::Passable => settings.passable_cost,
            Self::Free => 0,
            Self::Unknown => 255,
        }
    }

    /// Whether a cell of that cost becomes unknown when its evidence is stale.
    pub fn goes_stale(self) -> bool {
        matches!(self, Self::Passable | Self::Free)
    }
}

/// A layer of the map, from which a verdict has its sensor and its age.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// None of them.
    None = 0,
    /// Panes of glass.
    Panes = 1,
    /// Solidity.
    Lidar = 2,
    /// Occupancy.
    Camera = 3,
    /// Drops.
    Drops = 4,
}

/// A row of the rule: it applies where the states of all three layers meet its masks, and no row before it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Its number, from 1: the reason of a verdict.
    pub number: u32,
    /// The verdict in a word.
    pub name: &'static str,
    /// States of the panes that meet it.
    pub panes: u32,
    /// States of the lidars.
    pub lidar: u32,
    /// States of the cameras.
    pub camera: u32,
    /// Cost of the verdict.
    pub cost: Cost,
    /// The layer that it comes from.
    pub from: Layer,
}

const fn row(number: u32, name: &'static str, masks: [u32; 3], cost: Cost, from: Layer) -> Row {
    let [panes, lidar, camera] = masks;
    Row { number, name, panes, lidar, camera, cost, from }
}

/// The rule. No mask meets the last three rows: row 11 is what becomes of a free or passable cell whose evidence is stale, row 12 what
/// becomes of any cell that is not lethal where the ground drops away, row 13 of a gap between occupied cells.
pub const ROWS: [Row; 13] = [
    row(1, "glass", [panes::PANE, ANY, ANY], Cost::Lethal, Layer::Panes),
    row(2, "solid", [panes::NONE, lidar::SOLID, ANY], Cost::Lethal, Layer::Lidar),
    row(3, "transparent", [panes::NONE, lidar::TRANSPARENT, ANY], Cost::Lethal, Layer::Lidar),
    row(4, "occupied", [panes::NONE, lidar::PASSABLE, camera::OCCUPIED], Cost::Lethal, Layer::Camera),
    row(5, "refuted", [panes::NONE, lidar::REFUTING, camera::DOUBTFUL], Cost::Free, Layer::Lidar),
    row(6, "occupied", [panes::NONE, ANY, camera::OCCUPIED], Cost::Lethal, Layer::Camera),
    row(7, "passable", [panes::NONE, lidar::PASSABLE, NOT_OCCUPIED], Cost::Passable, Layer::Lidar),
    row(8, "free", [panes::NONE, lidar::FREE, NOT_OCCUPIED], Cost::Free, Layer::Lidar),
    row(9, "free", [panes::NONE, lidar::UNKNOWN, camera::FREE], Cost::Free, Layer::Camera),
    row(10, "unknown", [panes::NONE, lidar::UNKNOWN, camera::UNKNOWN], Cost::Unknown, Layer::None),
    row(STALE_ROW, "stale", [0, 0, 0], Cost::Unknown, Layer::None),
    row(DROP_ROW, "drop", [0, 0, 0], Cost::Lethal, Layer::Drops),
    row(BRIDGED_ROW, "bridged", [0, 0, 0], Cost::Lethal, Layer::Camera),
];

const NOT_OCCUPIED: u32 = camera::UNKNOWN | camera::FREE;

/// The rule as `settings` have it.
pub fn rows(settings: &RuleSettings) -> [Row; 13] {
    ROWS.map(|row| match (row.number, settings.lidar_clears_camera) {
        (4, _) if settings.passable_over_camera => {
            Row { name: "passable", cost: Cost::Passable, from: Layer::Lidar, ..row }
        }
        (5, LidarClearsCamera::Never) => Row { camera: 0, ..row },
        (5, LidarClearsCamera::Always) => Row { camera: camera::OCCUPIED, ..row },
        _ => row,
    })
}

/// The row that applies to these states; `None` for states that no cell has.
pub fn rule(settings: &RuleSettings, panes: u32, lidar: u32, camera: u32) -> Option<Row> {
    let meets = |row: &Row| row.panes & panes != 0 && row.lidar & lidar != 0 && row.camera & camera != 0;
    rows(settings).into_iter().find(meets)
}

/// The rule as WGSL, for a map of which only some layers `may_say` something (panes, lidars, cameras): rows that cannot apply
/// are left out. `lidar_state_of(class)`, `camera_state_of(state)`, and `rule_of(panes, lidar, camera)`, which gives a row as a
/// word: its cost in bits 0-7, its number in bits 8-11, its layer in bits 12-14, whether it goes stale in bit 16.
pub fn rule_wgsl(settings: &RuleSettings, [has_panes, has_lidars, has_cameras]: [bool; 3]) -> String {
    let mut text = String::from("// The rule (spec 4 §2), written out from its table.\n");
    let mut line = |line: String| text += &(line + "\n");
    for (name, value) in [
        ("PANES_NONE", panes::NONE),
        ("PANES_PANE", panes::PANE),
        ("LIDAR_UNKNOWN", lidar::UNKNOWN),
        ("LIDAR_FREE", lidar::FREE),
        ("LIDAR_REFUTING", lidar::REFUTING),
        ("CAMERA_UNKNOWN", camera::UNKNOWN),
        ("CAMERA_FREE", camera::FREE),
        ("CAMERA_OCCUPIED", camera::OCCUPIED),
        ("CAMERA_DOUBTFUL", camera::DOUBTFUL),
        ("DOUBTFUL_BELOW", DOUBTFUL_BELOW),
        ("LAYER_PANES", Layer::Panes as u32),
        ("LAYER_LIDAR", Layer::Lidar as u32),
        ("LAYER_CAMERA", Layer::Camera as u32),
    ] {
        line(format!("const {name} = {value}u;"));
    }
    line(format!("const REFUTING_WITHIN_M = {REFUTING_WITHIN_M};"));
    line(format!("const REFUTING_GAP_M = {REFUTING_GAP_M};"));
    line(switch("lidar_state_of", (0..).zip(CLASS_STATES), lidar::UNKNOWN));
    line(switch("camera_state_of", (0..).zip(CELL_STATES), camera::UNKNOWN));
    let rows = rows(settings);
    let word = |row: &Row| {
        let stale = u32::from(row.cost.goes_stale());
        row.cost.value(settings) | row.number << 8 | (row.from as u32) << 12 | stale << 16
    };
    for (name, number) in [("STALE", STALE_ROW), ("DROP", DROP_ROW)] {
        let value = rows.iter().filter(|row| row.number == number).map(word).next().unwrap_or(0);
        line(format!("const {name} = {value}u;"));
    }
    line("fn rule_of(panes: u32, lidar: u32, camera: u32) -> u32 {".into());
    let silent = [(has_panes, panes::NONE), (has_lidars, lidar::UNKNOWN), (has_cameras, camera::UNKNOWN)];
    let possible = |row: &&Row| {
        let masks = [row.panes, row.lidar, row.camera].into_iter().zip(silent);
        row.panes != 0 && masks.into_iter().all(|(mask, (says, nothing))| says || mask & nothing != 0)
    };
    for row in rows.iter().filter(possible) {
        let Row { panes, lidar, camera, .. } = row;
        let meets =
            format!("(panes & {panes}u) != 0u && (lidar & {lidar}u) != 0u && (camera & {camera}u) != 0u");
        line(format!("    if {meets} {{ return {}u; }}", word(row)));
    }
    line("    return 0u;\n}".into());
    text
}

/// What the passes that bridge gaps know of the rule, as WGSL: by bits, the rows of cells that cameras call occupied and of those that
/// may be bridged; and the word of the latter's new verdict, without sensor and age.
pub fn bridge_wgsl() -> String {
    let bits = |meets: fn(&Row) -> bool| {
        ROWS.iter().filter(|row| meets(row)).fold(0_u32, |bits, row| bits | 1 << row.number)
    };
    let occupied = bits(|row| row.camera & camera::OCCUPIED != 0 && row.from == Layer::Camera);
    let open = bits(|row| match row.cost {
        Cost::Unknown => true,
        Cost::Free => row.from == Layer::Camera,
        Cost::Lethal | Cost::Passable => false,
    });
    let bridged = Cost::Lethal.value(&RuleSettings::default()) | BRIDGED_ROW << 8;
    format!(
        "// Rows of the rule (spec 4 §2), from its table.\nconst OCCUPIED_ROWS = {occupied}u;\n\
         const BRIDGEABLE_ROWS = {open}u;\nconst BRIDGED = {bridged}u;\n"
    )
}

/// A function from numbers to numbers.
fn switch(name: &str, values: impl IntoIterator<Item = (u32, u32)>, otherwise: u32) -> String {
    let mut text = format!("fn {name}(number: u32) -> u32 {{\n    switch number {{\n");
    for (of, value) in values {
        let _ = writeln!(text, "        case {of}u: {{ return {value}u; }}");
    }
    text + &format!("        default: {{ return {otherwise}u; }}\n    }}\n}}")
}

/// The rule as a table in Markdown.
pub fn rule_markdown() -> String {
    let mut text =
        String::from("| # | panes | lidar | camera | verdict | cost |\n|---|---|---|---|---|---|\n");
    let switched = RuleSettings {
        passable_over_camera: true,
        lidar_clears_camera: LidarClearsCamera::Always,
        ..Default::default()
    };
    for (row, other) in ROWS.into_iter().zip(rows(&switched)) {
        let either =
            |a: String, b: String, key: &str| if a == b { a } else { format!("{a}, or {b} with `{key}`") };
        let camera = either(
            words(row.camera, &CAMERA_WORDS),
            words(other.camera, &CAMERA_WORDS),
            "lidar_clears_camera: always",
        );
        let verdict = either(row.name.into(), other.name.into(), "passable_over_camera");
        let cost = either(cost_words(row.cost), cost_words(other.cost), "passable_over_camera");
        let lidar = words(row.lidar, &LIDAR_WORDS);
        let panes = words(row.panes, &PANES_WORDS);
        let _ = match row.number {
            STALE_ROW => writeln!(
                text,
                "| {STALE_ROW} | any verdict of free or passable whose evidence is stale | | | {verdict} | {cost} |"
            ),
            DROP_ROW => writeln!(
                text,
                "| {DROP_ROW} | any verdict that is not lethal, where the ground drops away | | | {verdict} | {cost} |"
            ),
            BRIDGED_ROW => writeln!(
                text,
                "| {BRIDGED_ROW} | unknown, stale, or free by a camera, between two cells occupied by cameras that face each other (`fusion: evidence` and `learned`) | | | {verdict} | {cost} |"
            ),
            number => writeln!(text, "| {number} | {panes} | {lidar} | {camera} | {verdict} | {cost} |"),
        };
    }
    text
}

const PANES_WORDS: [&str; 2] = ["none", "pane"];
const LIDAR_WORDS: [&str; 6] =
    ["unknown", "free", "passable", "transparent", "solid", "free where the hits are, and newer"];
const CAMERA_WORDS: [&str; 4] = ["unknown", "free", "occupied", "occupied and doubtful"];

fn words(mask: u32, of: &[&str]) -> String {
    if mask == ANY {
        return "any".into();
    }
    let names = of.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, name)| *name);
    names.collect::<Vec<_>>().join(" or ")
}

fn cost_words(cost: Cost) -> String {
    match cost {
        Cost::Passable => "the passable cost".into(),
        stated => stated.value(&RuleSettings::default()).to_string(),
    }
}
