// Side of the tiles in which the farthest depth is kept, pixels.
const TILE = 8u;
