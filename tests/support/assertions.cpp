#include "support/assertions.h"

namespace fjell::test {

void assert_that(const Assertion& assertion, const Catch::ITransientExpression& expression) {
    Catch::AssertionHandler handler(Catch::StringRef(assertion.macro), {assertion.file, assertion.line},
                                    Catch::StringRef(assertion.expression),
                                    static_cast<Catch::ResultDisposition::Flags>(assertion.flags));
    handler.handleExpr(expression);
    handler.complete();
}

} // namespace fjell::test
