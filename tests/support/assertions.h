// Catch2's assertions, faster to compile: the same names, counts and reports, but an expression is parsed once where
// Catch2 parses it three times, and what an assertion does is in one function instead of at each of 5,000 places. What
// throws in an assertion fails its case without the assertion's place, as with CATCH_CONFIG_FAST_COMPILE.
#pragma once

#include <catch2/catch.hpp>

namespace fjell::test {

struct Assertion {
    const char *macro, *expression, *file;
    std::size_t line;
    int flags; // Catch::ResultDisposition::Flags
};

// Throws where the assertion has failed and ends its case.
void assert_that(const Assertion& assertion, const Catch::ITransientExpression& expression);
template <typename T>
void assert_that(const Assertion& assertion, const Catch::ExprLhs<T>& expression) {
    assert_that(assertion, static_cast<const Catch::ITransientExpression&>(expression.makeUnaryExpr()));
}

} // namespace fjell::test

#define FJELL_ASSERTION(macro, flags, ...)                                                                             \
    do {                                                                                                               \
        static constexpr ::fjell::test::Assertion assertion_{macro, #__VA_ARGS__, __FILE__, __LINE__, flags};          \
        ::fjell::test::assert_that(assertion_, Catch::Decomposer() <= __VA_ARGS__);                                    \
    } while (false)
#define FJELL_GOES_ON (+Catch::ResultDisposition::ContinueOnFailure)
#define FJELL_FALSE (+Catch::ResultDisposition::FalseTest)

#undef CHECK
#undef CHECK_FALSE
#undef REQUIRE
#undef REQUIRE_FALSE
#define CHECK(...) FJELL_ASSERTION("CHECK", FJELL_GOES_ON, __VA_ARGS__)
#define CHECK_FALSE(...) FJELL_ASSERTION("CHECK_FALSE", FJELL_GOES_ON | FJELL_FALSE, __VA_ARGS__)
#define REQUIRE(...) FJELL_ASSERTION("REQUIRE", Catch::ResultDisposition::Normal, __VA_ARGS__)
#define REQUIRE_FALSE(...) FJELL_ASSERTION("REQUIRE_FALSE", FJELL_FALSE, __VA_ARGS__)
