// Keeps a cell's word for the passes after it, for this scan alone.
@group(0) @binding(4) var<storage, read_write> cell_class: array<u32>;

fn keep_class(cell: u32, slot: u32, word: u32, said: bool, place: Place) {
    cell_class[cell] = word;
}
