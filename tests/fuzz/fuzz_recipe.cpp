// Recipes for baking: any text is refused in one line or is a recipe, which is written and read back the same.
#include <cstdint>
#include <string>
#include <string_view>

#include "baker/bake/recipe.h"
#include "input.h"

using namespace fjell;
using fuzz::must;

extern "C" int fuzz_recipe(const std::uint8_t* data, std::size_t size) {
    try {
        const baker::Recipe recipe = baker::parse_recipe({reinterpret_cast<const char*>(data), size}, "fuzz");
        must(baker::parse_recipe(baker::recipe_text(recipe), "fuzz") == recipe, "a recipe comes back as it was");
    } catch (const io::Failure& refused) {
        must(std::string_view(refused.what()).find('\n') == std::string_view::npos, "a refusal is one line");
    }
    return 0;
}
