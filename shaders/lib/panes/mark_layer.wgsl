// Marks a cell in the layer of panes (spec 4 §1): what this lidar kept of it goes, what it keeps now comes. Needs lib/record,
// lib/slot, lib/glass/pane.
//   x: id of the pane in bits 0-23, and sensor + 1; y: tick at which the pane was last found, 0: no pane
struct PaneLayerParams {
    tick: u32,
    sensor: u32,            // + 1
    first: u32,             // of the lidar's panes in map_panes
    origin_slot_x: u32,
    origin_slot_y: u32,
}

// The buffer `pane_cells`, whose name is the pass's.
@group(0) @binding(2) var<storage, read_write> pane_records: array<vec2<u32>>;
@group(0) @binding(3) var<uniform> pane_layer_params: PaneLayerParams;
@group(0) @binding(4) var<storage, read> map_panes: array<Pane>;

// The `number` in the list of the pane that crosses the cell; KEPT_PANES: none.
fn keep_pane(x: u32, y: u32, number: u32) {
    let side = pane_cells_params.side;
    let slot = slot_of(x, y, pane_layer_params.origin_slot_x, pane_layer_params.origin_slot_y, side);
    let old = pane_records[slot];
    if number >= KEPT_PANES {
        if old.y != 0u && sensor_of(old.x) == pane_layer_params.sensor {
            pane_records[slot] = vec2(0u);
        }
        return;
    }
    let pane = map_panes[pane_layer_params.first + number];
    if old.y == 0u || sensor_of(old.x) == pane_layer_params.sensor || old.y <= pane.age {
        let by = (pane.id & 0xffffffu) | (pane_layer_params.sensor << SENSOR_SHIFT);
        pane_records[slot] = vec2(by, max(pane.age, 1u));
    }
}
