// What the table of a profile's keys is written with.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "flight/profile_keys.h"

namespace fjell::flight {

// Where a value lies in a profile: a field, or a field of a part. shift: it is given in units of 1 << shift bytes.
template <auto Part, auto Field = nullptr, int shift = 0>
struct At {
    template <typename P>
    static auto& in(P& profile) {
        if constexpr (std::is_null_pointer_v<decltype(Field)>)
            return profile.*Part;
        else
            return profile.*Part.*Field;
    }
    static double get(const Profile& profile) {
        if constexpr (shift != 0)
            return static_cast<double>(in(profile) >> shift);
        else
            return static_cast<double>(in(profile));
    }
    static void set(Profile& profile, double value) {
        using T = std::remove_reference_t<decltype(in(profile))>;
        if constexpr (shift != 0)
            in(profile) = static_cast<T>(static_cast<std::uint64_t>(value) << shift);
        else
            in(profile) = static_cast<T>(value);
    }
};

// [light] and [layers], the last tables (profile_keys_light.cpp, profile_keys_layers.cpp).
[[nodiscard]] std::span<const ProfileKey> light_keys();
[[nodiscard]] std::span<const ProfileKey> layers_keys();

} // namespace fjell::flight
