// Whether pixels carry weights of their own; else every pixel with depth has weight 1 and sums are not needed.
override weighted: bool = true;
// Whether those above tau count fully (spec 1 §2), so that sums are not needed either.
override gated: bool = false;
