// Evidence that counts trust (spec 1 §9): R sets how fast a cell is believed, and looks through at the heights that were hit count
// against it. Needs lib/cell, lib/evidence, lib/fusion/strength, update.
//
// As with lambda, what is kept counts by looks, or by time where that is asked for or several cameras share the map. By time a look
// counts no more than one: what nobody looks at is not forgotten, and a slow camera needs as many looks as a fast one.
@group(0) @binding(9) var<uniform> evidence_params: EvidenceParams;

// What is left of the evidence for and against a cell after another look, and the most that is kept for it: a cell that was seen
// occupied for an hour is given up as fast as one of two seconds.
const KEPT_FOR = 0.95;
const KEPT_AGAINST = 0.8;
const MOST_FOR = 8.75;

// What a trusted floor point in a cell without hits adds against it.
const FLOOR_AGAINST = 0.07;

// Occupied where the evidence for is that many times what is against; no longer where it is under RELEASED times, or under LEAST_FOR.
const OCCUPIED_BY = 2.0;
const RELEASED_BY = 1.75;
const LEAST_FOR = 0.22;
// Free from so much against it; and the heights that were hit are forgotten where no more than FORGOTTEN_FOR is left.
const LEAST_AGAINST = 0.002;
const FORGOTTEN_FOR = 0.2;

// Consecutive hits in bits 8-15 of the state, observed frames in bits 16-31, the newest lowest: 1 = hit.
const RUN_SHIFT = 8u;
const HISTORY_SHIFT = 16u;

fn against(cell: Cell) -> f32 {
    return bitcast<f32>(cell.history);
}

fn share_through(i: u32) -> f32 {
    return f32(seen_through[i] & SHARE_ONE) / f32(SHARE_ONE);
}

fn has_floor(i: u32) -> bool {
    return cell_hits[i].top == FLOOR;
}

fn is_seen_through(i: u32) -> bool {
    return (seen_through[i] & SHARE_ONE) != 0u || has_floor(i);
}

// Share of the evidence that is for the cell.
fn occupancy_of(cell: Cell) -> f32 {
    let all = cell.occupancy + against(cell);
    return select(0.0, cell.occupancy / all, all > 0.0);
}

// a of the spec for the frame's hits in cell i.
fn evidence_for(i: u32, count: u32) -> f32 {
    let side = update_params.side;
    let centre = (vec2(f32(i % side), f32(i / side)) + 0.5) * evidence_params.resolution_m;
    let trust = select(f32(count), f32(cell_hits[i].weight) / update_params.weight_scale, weighted);
    return strength_of_hits(evidence_params, f32(count), trust, length(centre - evidence_params.camera_xy_m));
}

// How much of a look counts: looks that follow each other faster than a camera's nominal rate share one.
fn share_of_look(slot: u32) -> f32 {
    let last = cell_marks[slot].x;
    if !timed || last == 0u {
        return 1.0;
    }
    return min(1.0, f32(max(cell_marks_params.tick, last) - last) * evidence_params.looks_per_tick);
}

// Evidence after a look: what is left of the old, and the new, so that the sum of equal looks does not depend on their rate.
fn with_look(old: f32, added: f32, kept: f32, share: f32) -> f32 {
    let left = select(pow(kept, share), kept, share == 1.0);
    return left * old + (1.0 - left) / (1.0 - kept) * added;
}

fn next_state(old: u32, support: f32, opposed: f32, beside: bool, confirmed: bool) -> u32 {
    let need = select(NEED, NEED_BESIDE, beside);
    if support >= need && support >= OCCUPIED_BY * opposed && confirmed {
        return OCCUPIED;
    }
    if old == OCCUPIED && support >= LEAST_FOR && support >= RELEASED_BY * opposed {
        return OCCUPIED;
    }
    if opposed >= LEAST_AGAINST && support < RELEASED_BY * opposed {
        return FREE;
    }
    return select(old, UNKNOWN, old == OCCUPIED);
}

// Takes a look into the cell; gives a, or 0 without hits.
fn fuse(i: u32, slot: u32, look: Look, cell: ptr<function, Cell>) -> f32 {
    let run = select(0u, min((((*cell).state >> RUN_SHIFT) & 0xffu) + 1u, 255u), look.hit);
    let history = (((*cell).state >> HISTORY_SHIFT) << 1u) | select(0u, 1u, look.hit);
    let kept_bits = (run << RUN_SHIFT) | (history << HISTORY_SHIFT);
    var now = see_state((*cell).state);
    if look.hit {
        (*cell).top = max((*cell).top, cell_hits[i].top);
    }
    if look.hit && !hit_often(history) {
        (*cell).state = now | kept_bits;
        return UNSEEN;
    }
    let share = share_of_look(slot);
    let a = select(0.0, evidence_for(i, max(look.count, 1u)), look.hit);
    let b = share_through(i) + select(0.0, FLOOR_AGAINST, look.seen && has_floor(i));
    let support = min(with_look((*cell).occupancy, a, KEPT_FOR, share), MOST_FOR);
    let opposed = with_look(against(*cell), b, KEPT_AGAINST, share);
    // What is against may fade in a look without hits, so that what is for is enough.
    let confirmed = update_params.confirmations <= 1u || run >= update_params.confirmations;
    now = next_state(now, support, opposed, (seen_through[i] & BESIDE) != 0u, confirmed);
    if now == FREE && support < FORGOTTEN_FOR {
        (*cell).top = 0u;
    }
    (*cell).occupancy = support;
    (*cell).history = bitcast<u32>(opposed);
    (*cell).state = now | kept_bits;
    return a;
}
