// Horizons (fjell/texture.h), for the baker and for ground that moves: directions, and the light of the sky above one.
#pragma once

#include <cmath>

#include "fjell/texture.h"

namespace fjell {

// Sines and cosines of 0, 24, 48 .. degrees.
inline constexpr double horizon_east[horizon_directions] = {0,
                                                            0.4067366430758002,
                                                            0.7431448254773942,
                                                            0.9510565162951535,
                                                            0.9945218953682733,
                                                            0.8660254037844387,
                                                            0.5877852522924732,
                                                            0.2079116908177593,
                                                            -0.2079116908177595,
                                                            -0.587785252292473,
                                                            -0.8660254037844384,
                                                            -0.9945218953682734,
                                                            -0.9510565162951536,
                                                            -0.7431448254773946,
                                                            -0.4067366430758002};
inline constexpr double horizon_south[horizon_directions] = {-1.0,
                                                             -0.9135454576426009,
                                                             -0.6691306063588582,
                                                             -0.3090169943749475,
                                                             0.1045284632676536,
                                                             0.4999999999999998,
                                                             0.8090169943749473,
                                                             0.9781476007338057,
                                                             0.9781476007338056,
                                                             0.8090169943749476,
                                                             0.5000000000000004,
                                                             0.1045284632676534,
                                                             -0.3090169943749472,
                                                             -0.6691306063588578,
                                                             -0.913545457642601};

inline constexpr double horizon_growth = 1.122462048309373; // 2^(1/6): a ray doubles its distance in six steps

// Light of the sky over elevations above a horizon with that sine, in one direction, on a surface whose unit normal has
// the components `level` (along the direction) and `up`: the integral of its cosine, over half a direction's share. The
// arc cosine after M. Abramowitz and I. Stegun, 4.4.45: to 7e-5.
inline float sky_above(float sine, float level, float up) {
    const float cosine2 = 1 - sine * sine;
    const float arc =
        std::sqrt(1 - sine) * (1.5707288f + sine * (-0.2121144f + sine * (0.0742610f - sine * 0.0187293f)));
    const float light = level * (arc - sine * std::sqrt(cosine2)) + up * cosine2;
    return light > 0 ? light : 0;
}

} // namespace fjell
