// Where each lane of a workgroup begins to write, from how many each has to write. Needs LANES, the lanes of a workgroup.
var<workgroup> starts: array<u32, LANES>;
var<workgroup> total: u32;

fn share_starts(lane: u32, count: u32) {
    starts[lane] = count;
    workgroupBarrier();
    for (var k = 0u; k < select(0u, LANES, lane == 0u); k++) {
        let here = starts[k];
        starts[k] = select(total, 0u, k == 0u);
        total = starts[k] + here;
    }
    workgroupBarrier();
}
