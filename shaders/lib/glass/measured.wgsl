// What a scan shows along the ray to a place, by the cells around it. Needs lib/glass/grid, lib/glass/row_texels and the buffer
// `beam_cells`.

// Cells of the 3 x 3 around a ray that must be measured for a place to be free.
const LEAST_MEASURED = 4u;

struct Shown {
    matches: bool,      // a surface lies there
    beyond: bool,       // the sensor sees through that place
    known: bool,        // something is measured along the ray or beside it
}

fn tolerance(range_m: f32) -> f32 {
    return glass_params.match_m + glass_params.match_per_m * range_m;
}

// Cells around one, a number of columns and rows to each side: columns go round, rows end.
struct Around {
    column: u32,        // the first
    least_row: u32,
    end_row: u32,       // one past the last
}

fn cells_around(column: u32, row: u32, columns: u32, rows: u32) -> Around {
    let first = column + glass_params.columns - columns;
    return Around(
        select(first, first - glass_params.columns, first >= glass_params.columns),
        max(row, rows) - rows,
        min(row + rows + 1u, glass_params.rows),
    );
}

fn next_column(column: u32) -> u32 {
    return select(column + 1u, 0u, column + 1u == glass_params.columns);
}

// Against what is measured along the ray to a mirrored place (spec 3 §5, step 2).
fn against_measured(image: vec3<f32>) -> Shown {
    return shown_at(image, tolerance(length(image)));
}

// As against_measured, with ranges that are the same when they differ by less than `near`.
fn shown_at(image: vec3<f32>, near: f32) -> Shown {
    let range_m = length(image);
    let row = row_of_bin(elevation_bin(image));
    if row >= glass_params.rows {
        return Shown(false, false, false);
    }
    let column = column_of(image, glass_params.columns);
    var around = cells_around(column, row, 1u, 1u);
    var matches = false;
    var passes = beam_cells[2u * (column * glass_params.rows + row)] != NONE;
    var count = 0u;
    for (var c = 0u; c < 3u; c++) {
        for (var r = around.least_row; r < around.end_row; r++) {
            let word = beam_cells[2u * (around.column * glass_params.rows + r)];
            if word != NONE {
                let measured_m = f32(steps_in(word)) / RANGE_STEPS_PER_M;
                matches = matches || abs(measured_m - range_m) < near;
                passes = passes && measured_m > range_m + near;
                count += 1u;
            }
        }
        around.column = next_column(around.column);
    }
    return Shown(matches, passes && count >= LEAST_MEASURED, count > 0u);
}
