// What the passes of learned solidity share. Needs the uniform `solidity_params`.
struct SolidityParams {
    lidar: vec2<f32>,           // the lidar in the window, metres
    resolution_m: f32,
    side: u32,
    height_min_m: f32,          // what lies lower above the ground is floor
    height_max_m: f32,          // what lies higher is over the robot
    bright_at_1m: f32,          // trend of the scan's log2 of intensity: at 1 m
    bright_slope: f32,          // and its growth with log2 of range
    bright_scale: f32,          // 1 / deviation from the trend; 0: intensities say nothing
    two_returns: f32,           // 1: the sensor gives two returns of a beam
    judged: u32,                // 0: the scan is too flat to judge by shape, all that stands is solid
    ground_stated: u32,         // 1: a stated ground lies below the lidar
    least_returns: u32,         // returns in a cell and around it, under which it is solid
    reach_cells: u32,           // cells to each side that count as around a cell
    block_cells: u32,           // side of a block, cells
    blocks: u32,                // blocks along a side
}

// Words of a cell's counts:
//   0-3  returns by height above the ground, see `band_of`
//   4    lowest return, as ROOF_STEPS - steps above the ground; 5: highest, as 1 + steps; 0: none
//   6, 7 sums of where along the beam returns lie, and of its square, in steps of 1/64 cell from 3/4 cell before the centre
//   8    returns whose beam has another return
//   9-11 returns with an intensity; sums of their contrast, in steps of 1/16 deviation from 4 deviations under the trend, and of its
//        square
//   12   returns over the robot
// Behind all cells the blocks of half a metre: returns by height, the highest.
const CELL_COUNTS = 13u;
const BLOCK_COUNTS = 5u;
const BANDS = 4u;
const HEIGHT_STEPS_PER_M = 256.0;
const ROOF_STEPS = 65536u;
const DEPTH_STEPS = 64.0;
const DEPTH_ZERO = 0.75;
const CONTRAST_STEPS = 16.0;
const CONTRAST_ZERO = 4.0;

// Words of a bin of beams: farthest, MOST_BEAM_STEPS - nearest + 1, beams. Behind all bins the beams of each bin of slopes.
const BIN_WORDS = 3u;
const MOST_BEAM_STEPS = 262143u;

fn block_word(cell: vec2<u32>) -> u32 {
    let block = cell / max(solidity_params.block_cells, 1u);
    let cells = solidity_params.side * solidity_params.side;
    return CELL_COUNTS * cells + BLOCK_COUNTS * (block.y * solidity_params.blocks + block.x);
}

fn band_of(above_m: f32) -> u32 {
    return select(0u, 1u, above_m >= 0.4) + select(0u, 1u, above_m >= 0.8) + select(0u, 1u, above_m >= 1.3);
}
