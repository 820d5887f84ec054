// Evidence for and against a cell (spec 1 §9): what see_through/gather leaves for update, and what they share. A cell keeps
// the evidence for it in place of p, that against it in place of the history.

// Share of looks through in the low bits of a word of seen_through, fixed-point one; and whether the cell lies beside one that was
// occupied before the frame.
const SHARE_ONE = 65535u;
const BESIDE = 0x10000u;

// Evidence for a cell that makes it occupied, and beside one that is occupied by as much.
const NEED = 1.75;
const NEED_BESIDE = 0.44;
