// Moving ground in pictures: where heights have changed, the light is that of the new ground, on the whole maps of a
// pack as on maps that come later.
#include <cmath>

#include "fjell/edit.h"
#include "picture_scene.h"

using namespace pictures;

namespace {

// The mean difference of two pictures, in codes.
double difference(const Picture& a, const Picture& b) {
    double sum = 0;
    REQUIRE(a.colour.rgb.size() == b.colour.rgb.size());
    for (std::size_t i = 0; i < a.colour.rgb.size(); ++i)
        sum += std::abs(static_cast<double>(a.colour.rgb[i]) - static_cast<double>(b.colour.rgb[i]));
    return sum / static_cast<double>(a.colour.rgb.size());
}

} // namespace

TEST_CASE("the light on ground that has moved is that on a pack that was baked from the new heights") {
    Scene moved(mountains(257), 7); // four tiles, and the crater lies over their common corner
    const Terrain& terrain = moved.loaded.terrain;
    const io::AlignedMemory memory = io::allocate(edits_bytes(terrain.header()));
    Edits edits;
    REQUIRE(create_edits(terrain, {}, {memory.get(), edits_bytes(terrain.header())}, edits).ok());
    Stamp crater;
    crater.shape = StampShape::crater;
    crater.x_m = terrain.x_m(133), crater.z_m = terrain.z_m(125);
    crater.radius_m = 900, crater.falloff_m = 400, crater.amount_m = 300;
    StampId id = 0;
    EditReport report;
    REQUIRE(push_stamp(edits, crater, id).ok());
    REQUIRE(update_edits(edits, {}, {}, report).ok());
    REQUIRE((report.applied == 1 && report.samples > 1000));

    baker::Dem dem = mountains(257);
    for (std::int32_t row = 0; row < 257; ++row)
        for (std::int32_t column = 0; column < 257; ++column)
            dem.heights_m[static_cast<std::size_t>(row * 257 + column)] = data_of(terrain).height_m({column, row});
    Scene baked(std::move(dem), 7);

    // Tiles in their colours, so that light alone differs; the crater fills most of the picture.
    const gl::DrawOptions options{.mode = gl::Mode::tiles};
    const View view = moved.camera(0.52, 0.62, 900, 0, -35);
    const OwnMesh mesh = full_resolution(terrain);
    const Picture expected = baked.draw(full_resolution(baked.loaded.terrain).view(), view, options);
    const double before = difference(moved.draw(mesh.view(), view, options), expected);
    moved.renderer->show_ground(edits);
    const double after = difference(moved.draw(mesh.view(), view, options), expected);
    CAPTURE(before, after);
    CHECK(before > 2);
    CHECK(after < before / 10);
    CHECK(after < 0.5);

    // A renderer that is made later learns of it too.
    moved.renderer = gl::Renderer::create(terrain, moved.loaded.pack,
                                          {.vertices = static_cast<std::uint32_t>(mesh.vertices.size()),
                                           .indices = static_cast<std::uint32_t>(mesh.indices.size())});
    moved.renderer->show_ground(edits);
    CHECK(difference(moved.draw(mesh.view(), view, options), expected) == after);
}
