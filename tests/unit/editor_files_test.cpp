int unused_so_far;
