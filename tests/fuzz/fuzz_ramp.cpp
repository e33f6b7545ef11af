// Ramps: any text is refused or is a ramp, which paints colours everywhere and is the same when it is written and read.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "baker/maps/colour.h"
#include "fjell/io/failure.h"
#include "input.h"

namespace {

using namespace fjell;
using baker::Ramp;
using fuzz::must;

std::string text_of(const double (&rgb)[3]) {
    return fmt::format("[{}, {}, {}]", rgb[0], rgb[1], rgb[2]);
}

std::string text_of(const std::vector<Ramp::Stop>& stops) {
    std::string text;
    for (const Ramp::Stop& s : stops)
        text +=
            fmt::format("{}{{\"height_m\": {}, \"rgb\": {}}}", text.empty() ? "" : ", ", s.height_m, text_of(s.rgb));
    return "[" + text + "]";
}

std::string text_of(const Ramp& ramp) {
    std::string slopes;
    for (const Ramp::Layer& l : ramp.slopes)
        slopes += fmt::format(
            "{}{{\"from_degrees\": {}, \"degrees\": {}, {}}}", slopes.empty() ? "" : ", ", l.from_degrees, l.degrees,
            l.stops.size() == 1 ? "\"rgb\": " + text_of(l.stops[0].rgb) : "\"stops\": " + text_of(l.stops));
    return fmt::format("{{\"relative\": {}, \"stops\": {}, \"slopes\": [{}]}}", ramp.relative, text_of(ramp.stops),
                       slopes);
}

void paint(const Ramp& ramp) {
    baker::RampPainter painter(absolute(ramp, -100, 2500));
    for (const float up : {1.0f, 0.97f, 0.7f, 0.3f, 0.0f})
        for (const float height_m : {-12000.0f, -100.0f, 0.0f, 1.0f, 999.5f, 2500.0f, 30000.0f}) {
            float rgb[3];
            painter.paint(height_m, up, rgb);
            must(std::all_of(rgb, rgb + 3, [](float c) { return c >= -0.5f && c <= 255.5f; }), "a colour is one");
        }
}

} // namespace

extern "C" int fuzz_ramp(const std::uint8_t* data, std::size_t size) {
    try {
        const Ramp ramp = baker::parse_ramp({reinterpret_cast<const char*>(data), size}, "fuzz");
        const std::string text = text_of(ramp);
        must(text_of(baker::parse_ramp(text, "written")) == text, "a ramp comes back as it was");
        paint(ramp);
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
        must(std::string(refused.what()).rfind("written", 0) != 0, "what is written is not refused");
    }
    return 0;
}
