// Keeps a cell's word in the solidity layer (spec 4 §1). Needs lib/record, lib/scan and a part that gives beams_across.
//   x: the word; y: tick of the last evidence; z: heights between which beams crossed a free cell, 16 bits each, from
//   CROSSING_ZERO_M below the ground, 0: not known; w: largest gap between two of these beams, and sensor + 1
struct SolidCellsParams {
    tick: u32,
    sensor: u32,                // + 1
    lidar_height_m: f32,        // above the ground
    pad: u32,
}

@group(0) @binding(4) var<storage, read_write> solid_cells: array<vec4<u32>>;
@group(0) @binding(7) var<uniform> solid_cells_params: SolidCellsParams;

// Whether what another lidar saw stays: solid wins where the two disagree on how solid a thing is (spec 2 §3), and glass that
// one lidar saw head on is what another sees through.
fn other_wins(old: vec4<u32>, kind: u32) -> bool {
    let before = old.x & 0xffu;
    let other = old.y != 0u && sensor_of(old.w) != solid_cells_params.sensor;
    return other
        && ((before == SOLID && (kind == PASSABLE || kind == TRANSPARENT))
            || (before == TRANSPARENT && (kind == PASSABLE || kind == FREE)));
}

// What the layer holds stays where the scan says nothing of the cell, or says it late.
fn keep_class(cell: u32, slot: u32, word: u32, said: bool, place: Place) {
    let old = solid_cells[slot];
    if old.y > solid_cells_params.tick || (said && other_wins(old, word & 0xffu)) {
        return;
    }
    if !said {
        // Glass that only this lidar remembers fades as its memory does, from when it was seen.
        let mine = sensor_of(old.w) == solid_cells_params.sensor && old.y != 0u;
        if mine && (old.x & 0xffu) == TRANSPARENT {
            solid_cells[slot] = select(vec4(0u), vec4(word, old.yzw), (word & 0xffu) == TRANSPARENT);
        }
        return;
    }
    var beams = vec2(0u);
    if (word & 0xffu) == FREE {
        beams = beams_across(place, solid_cells_params.lidar_height_m);
    }
    solid_cells[slot] = vec4(
        word,
        solid_cells_params.tick,
        beams.x,
        beams.y | (solid_cells_params.sensor << SENSOR_SHIFT),
    );
}
