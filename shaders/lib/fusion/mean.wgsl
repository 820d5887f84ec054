// The mean of the weights, forgotten by lambda (spec 1 §3, §4). Needs lib/cell, update.

fn is_seen_through(i: u32) -> bool {
    return seen_through[i] == 1u;
}

fn occupancy_of(cell: Cell) -> f32 {
    return cell.occupancy;
}

// e of the spec: mean weight of the hits, 0 where seen through, UNSEEN where nothing may be said.
fn evidence_of(i: u32, count: u32, hit: bool, seen: bool, history: u32) -> f32 {
    if !hit {
        return select(UNSEEN, 0.0, seen);
    }
    if !hit_often(history) {
        return UNSEEN;
    }
    if !weighted || gated {
        return 1.0;
    }
    return f32(cell_hits[i].weight) / (f32(count) * update_params.weight_scale);
}

// Occupied from occupied_threshold up and until below free_threshold; free only by being seen through.
fn next_state(old: u32, p: f32, confirmed: bool, seen: bool) -> u32 {
    if old == OCCUPIED && p >= update_params.free_threshold {
        return OCCUPIED;
    }
    if p >= update_params.occupied_threshold && confirmed {
        return OCCUPIED;
    }
    if seen && p < update_params.free_threshold {
        return FREE;
    }
    return select(old, UNKNOWN, old == OCCUPIED);
}

fn lambda_of(slot: u32) -> f32 {
    let last = cell_marks[slot].x;
    if !timed || last == 0u {
        return update_params.lambda;
    }
    let since = max(cell_marks_params.tick, last) - last;
    return exp2(cell_marks_params.log2_lambda_per_tick * f32(since));
}

// Takes a look into the cell; gives its e.
fn fuse(i: u32, slot: u32, look: Look, cell: ptr<function, Cell>) -> f32 {
    let run = select(0u, min(((*cell).state >> 8u) + 1u, 255u), look.hit);
    var now = see_state((*cell).state);
    (*cell).history = ((*cell).history << 1u) | select(0u, 1u, look.hit);
    let e = evidence_of(i, look.count, look.hit, look.seen, (*cell).history);
    if e >= 0.0 {
        let lambda = lambda_of(slot);
        (*cell).occupancy = lambda * (*cell).occupancy + (1.0 - lambda) * e;
        now = next_state(now, (*cell).occupancy, run >= update_params.confirmations, look.seen);
    }
    (*cell).top = select(max((*cell).top, cell_hits[i].top), select((*cell).top, 0u, now == FREE), look.seen);
    (*cell).state = now | (run << 8u);
    return e;
}
