// How far a pane goes on along lines of squares of its survey, and what lines of beams show head on. Part of the pass glass/accept:
// needs its sums, bounds and counts.

// A frame is no wider than this, metres; a wall ends the pane.
const WIDEST_FRAME_M = 0.75;
// A sheet of glass is no wider than this, metres (float glass is made 3.21 m wide); a line of squares has a frame where this
// share of its beams ends on the plane.
const WIDEST_SHEET_M = 3.0;
const LEAST_ON_FRAME = 0.08;
// Within this share of the patch where glass always shows no more than this share of the beams goes on without showing it, in most
// lines, if there are enough: strings, grilles and plants give two returns in a plane too, and let some beams through wherever
// they are met.
const HEAD_ON_SHARE = 0.5;
const MOST_PASSING = 0.05;
const LEAST_HEAD_ON = 30u;

// Goes on from `from_line` while the lines show glass or a view through, over frames but not over walls. Along u no farther
// than a sheet is wide from a line that shows glass or has something on the plane: beyond, the way beside it is open.
fn grow(from_line: u32, lines: u32, up: bool, along_u: bool) -> u32 {
    var end = from_line;
    var reached = from_line;
    var closed = 0u;
    var bare = 0u;
    let most = u32(WIDEST_FRAME_M / SQUARE_M);
    let widest = select(lines, u32(WIDEST_SHEET_M / SQUARE_M), along_u);
    for (var k = 1u; k < lines; k++) {
        let line = select(from_line - k, from_line + k, up);
        if (up && line >= lines) || (!up && k > from_line) || closed > most || bare > widest || is_air(line) {
            break;
        }
        let sum = sums[line];
        let beams = sum.x + sum.y + sum.z + sum.w;
        let open = f32(sum.x + select(sum.y, 0u, gives_two()) + sum.w) >= OPEN_SHARE * f32(beams);
        let bounded = f32(sum.x + sum.y + sum.z) >= LEAST_ON_FRAME * f32(beams);
        if beams >= LEAST_BEAMS {
            closed = select(closed + 1u, 0u, open);
            reached = select(reached, line, open);
        }
        bare = select(bare + 1u, 0u, bounded && beams > 0u);
        end = select(end, reached, bare == 0u || !along_u);
    }
    return end;
}

// Of an upright line of squares of the pane, beams met head on: all, where next to none goes on; all, where some do and others show
// glass. Beside open air, over a railing too, a square is partly air. Needs the sums of the lines of v.
fn head_on_at(line: u32) -> vec2<u32> {
    var sum = vec2(0u);
    if line >= bounds.x && line <= bounds.y {
        for (var row = bounds.z; row < bounds.w + 1u; row++) {
            let counts = counts_at(line, row);
            let air = is_air(max(row, 1u) - 1u) || is_air(row) || is_air(min(row + 1u, SURVEY_HIGH - 1u));
            let counted = !air && off_foot(line, row) < HEAD_ON_SHARE * reach_m();
            sum += select(vec2(0u), counts.xw, counted);
        }
    }
    let all = sum.x + sum.y;
    let leaks = f32(sum.y) > MOST_PASSING * f32(all);
    let shows = f32(sum.x) >= LEAST_SHOWING * f32(all);
    return select(vec2(all, 0u), select(vec2(0u), vec2(0u, all), shows), leaks);
}
