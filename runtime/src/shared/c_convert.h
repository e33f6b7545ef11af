// Between a type of C and the type of C++ that it stands for. Nothing is decided here: the two lie alike in memory, a
// descriptor and a report behind their struct_size, so that every conversion is a cast or a copy. types.py writes both
// fjell_c_types.h and types.inc, which compares them while this is compiled.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "fjell/fjell.h"
#include "fjell/fjell_c.h"
#include "shared/compiler.h"

namespace fjell::c_api {

// Bytes of a type of C before the fields that C++ knows of.
template <typename C>
inline constexpr std::size_t before = 0;
template <typename C>
requires requires(C c) {
    c.struct_size;
}
inline constexpr std::size_t before<C> = sizeof(std::uint64_t);

// Bytes of a field. A span is a pointer and a count, two fields of C, as the implementations of the standard library
// have it; a test looks that the pointer comes first.
template <typename T>
inline constexpr std::size_t field_bytes = sizeof(T);
template <typename T>
inline constexpr std::size_t field_bytes<std::span<T>> = sizeof(void*);
static_assert(sizeof(std::span<const std::byte>) == 2 * sizeof(void*));

template <typename C>
struct CppOf;
template <typename Cpp>
struct COf;
#define FJELL_AT(field)                                                                                                \
    static_assert(offsetof(C, field) == before<C> + offsetof(Type, field) &&                                           \
                      field_bytes<decltype(C::field)> == field_bytes<decltype(Type::field)>,                           \
                  "the C++ type has changed: run runtime/src/c/types.py");
#define FJELL_C_TYPE(Name, fields)                                                                                     \
    template <>                                                                                                        \
    struct CppOf<Fjell##Name> {                                                                                        \
        using C = Fjell##Name;                                                                                         \
        using Type = Name;                                                                                             \
        static_assert(sizeof(C) == (before<C> + sizeof(Type) + alignof(C) - 1) / alignof(C) * alignof(C) &&            \
                          std::is_trivially_copyable_v<Type>,                                                          \
                      "the C++ type has changed: run runtime/src/c/types.py");                                         \
        fields                                                                                                         \
    };                                                                                                                 \
    template <>                                                                                                        \
    struct COf<Name> {                                                                                                 \
        using Type = Fjell##Name;                                                                                      \
    };
#include "c/types.inc"
#undef FJELL_C_TYPE
#undef FJELL_AT

// --- values, without struct_size ---

template <typename C>
[[nodiscard]] auto to_cpp(const C& value) {
    return bits_as<typename CppOf<C>::Type>(value);
}
template <typename Cpp>
[[nodiscard]] auto to_c(const Cpp& value) {
    return bits_as<typename COf<Cpp>::Type>(value);
}

// What a pointer of the host's points to; for NULL one that is all defaults.
template <typename C>
[[nodiscard]] const auto& at(const C* from) {
    static constexpr typename CppOf<C>::Type none{};
    return from == nullptr ? none : *reinterpret_cast<const typename CppOf<C>::Type*>(from);
}

// Where a call is to write; NULL is refused as the argument of that name.
[[nodiscard]] inline FjellStatus refused(const char* argument) {
    return {FJELL_OUT_OF_RANGE, argument};
}
// A call that returned a status has made this: the host gets it when all is well.
template <typename Cpp>
[[nodiscard]] FjellStatus give(Status status, const Cpp& made, typename COf<Cpp>::Type* to) {
    if (status.ok()) *to = to_c(made);
    return to_c(status);
}

// --- spans ---

template <typename T>
[[nodiscard]] std::span<T> span_of(T* first, std::size_t count) {
    return {first, first == nullptr ? 0 : count};
}
[[nodiscard]] inline std::span<const std::byte> span_of(const void* first, std::size_t bytes) {
    return span_of(static_cast<const std::byte*>(first), bytes);
}
[[nodiscard]] inline std::span<std::byte> span_of(void* first, std::size_t bytes) {
    return span_of(static_cast<std::byte*>(first), bytes);
}
template <typename Cpp>
[[nodiscard]] auto elements(std::span<const Cpp> span) {
    return reinterpret_cast<const typename COf<Cpp>::Type*>(span.data());
}
template <typename Cpp>
[[nodiscard]] auto elements(std::span<const Cpp> span, std::size_t* count) {
    if (count != nullptr) *count = span.size();
    return elements(span);
}

// --- descriptors and reports, which begin with struct_size ---

inline constexpr char struct_size[] = "struct_size";

template <typename C>
[[nodiscard]] bool fits(const C* sized) {
    return sized == nullptr || (sized->struct_size >= before<C> && sized->struct_size <= sizeof(C));
}
// How much of the C++ type the host knows of.
template <typename C>
[[nodiscard]] std::size_t known_bytes(const C* sized) {
    return std::min(static_cast<std::size_t>(sized->struct_size) - before<C>, sizeof(typename CppOf<C>::Type));
}

// A descriptor: what the host has set, over the defaults.
template <typename C>
class In {
public:
    explicit In(const C* from) : ok(fits(from)) {
        if (ok && from != nullptr)
            std::memcpy(&value, reinterpret_cast<const std::byte*>(from) + before<C>, known_bytes(from));
    }
    typename CppOf<C>::Type value{};
    bool ok; // struct_size is one that the library knows
};

// Views as an update takes them. Of more than any cut has none is read, and one more is passed on, so that they are
// refused where they always are.
class Views {
public:
    Views(const FjellView* first, std::size_t count)
        : ok(fits(first)), count_(first == nullptr ? 0 : std::min<std::size_t>(count, max_cut_views + 1)) {
        for (std::size_t i = 0; ok && count_ <= max_cut_views && i < count_; ++i) {
            const auto* at =
                reinterpret_cast<const std::byte*>(first) + i * static_cast<std::size_t>(first->struct_size);
            std::memcpy(&view_[i], at + before<FjellView>, known_bytes(first));
        }
    }
    [[nodiscard]] std::span<const View> all() const { return {view_, count_}; }
    bool ok;

private:
    View view_[max_cut_views + 1];
    std::size_t count_;
};

// As much of a report as the host knows.
template <typename Cpp>
void write(const Cpp& from, typename COf<Cpp>::Type* to) {
    if (to != nullptr && fits(to))
        std::memcpy(reinterpret_cast<std::byte*>(to) + before<typename COf<Cpp>::Type>, &from, known_bytes(to));
}

} // namespace fjell::c_api
