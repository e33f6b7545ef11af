// The decision (view/wanted.h), in terms of Add(), Mul() and what else a namespace has for its floats or vectors V:
// each that has them includes this once, hence no guard. d: the tag that Set() takes. No fused multiply-add, or
// decisions would differ from machine to machine.

template <typename V>
FJELL_ALWAYS_INLINE inline V squared_sum(V x2, V dy, V z2) {
    return Add(Add(x2, Mul(dy, dy)), z2);
}
template <typename D, typename V>
FJELL_ALWAYS_INLINE inline V squared_distance(D d, const Reach& r, V x, V y, V z) {
    const V dx = Sub(x, Set(d, r.eye_x)), dy = Sub(y, Set(d, r.eye_y)), dz = Sub(z, Set(d, r.eye_z));
    return squared_sum(Mul(dx, dx), dy, Mul(dz, dz));
}
template <typename D, typename V>
FJELL_ALWAYS_INLINE inline V reach_m(D d, const Reach& r, V error_m, V radius_m) {
    return Add(Mul(Add(radius_m, Mul(error_m, Set(d, r.q))), Set(d, reach_grow)), Set(d, r.pad));
}
template <typename V>
FJELL_ALWAYS_INLINE inline auto is_within(V squared, V reach) {
    return Lt(squared, Mul(reach, reach));
}

// What one view says, on top of what others have said: how far the eye may go before it says otherwise, and how large
// the numbers are that this was computed from.
template <typename V, typename M>
FJELL_ALWAYS_INLINE inline void add_view(V squared, V distance, V reach, V& margin, V& span, M& is_wanted) {
    margin = Max(margin, Sub(reach, distance));
    span = Max(span, Add(reach, distance));
    is_wanted = Or(is_wanted, is_within(squared, reach));
}
// Less than 0: it may say otherwise already.
template <typename D, typename V>
FJELL_ALWAYS_INLINE inline V slack_m(D d, V margin, V span) {
    return Sub(Abs(margin), Mul(span, Set(d, slack_rounding)));
}
