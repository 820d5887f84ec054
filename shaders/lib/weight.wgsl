// Whether pixels carry weights of their own; else every pixel with depth has weight 1 and sums are not needed.
override weighted: bool = true;
