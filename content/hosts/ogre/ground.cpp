#include "ground.h"

#include <cmath>
#include <string>

#include <OgreHardwareBufferManager.h>
#include <OgreMaterial.h>
#include <OgreNode.h>
#include <OgreRenderQueue.h>
#include <OgreTechnique.h>

namespace host {

Ground::Range::Range(const Ground& ground, Ogre::VertexData* vertices, Ogre::HardwareIndexBufferSharedPtr indices)
    : ground_(ground), vertices_(vertices) {
    indices_.indexBuffer = std::move(indices);
}

void Ground::Range::getRenderOperation(Ogre::RenderOperation& operation) {
    operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
    operation.vertexData = vertices_;
    operation.indexData = &indices_;
    operation.useIndexes = true;
}

void Ground::Range::getWorldTransforms(Ogre::Matrix4* to) const {
    *to = Ogre::Matrix4::IDENTITY; // the vertex program places them
}

Ground::Ground(const fjell::Terrain& terrain, const fjell::CutBudget& budget, Ogre::MaterialPtr material)
    : MovableObject("ground"), terrain_(terrain), material_(std::move(material)) {
    // OGRE has no integers in vertices that all its render systems pass on: columns and rows are floats, which hold
    // whole numbers below 2^24.
    Ogre::VertexDeclaration& format = *vertices_.vertexDeclaration;
    format.addElement(0, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);            // column, row, height_m
    format.addElement(1, 0, Ogre::VET_FLOAT4, Ogre::VES_TEXTURE_COORDINATES); // MorphVertex
    auto& buffers = Ogre::HardwareBufferManager::getSingleton();
    const auto usage = Ogre::HardwareBuffer::HBU_DYNAMIC;
    vertex_buffer_ = buffers.createVertexBuffer(3 * sizeof(float), budget.vertices, usage, false);
    morph_buffer_ = buffers.createVertexBuffer(sizeof(fjell::MorphVertex), budget.vertices, usage, false);
    index_buffer_ =
        buffers.createIndexBuffer(Ogre::HardwareIndexBuffer::IT_32BIT, std::size_t{3} * budget.triangles, usage, false);
    vertices_.vertexBufferBinding->setBinding(0, vertex_buffer_);
    vertices_.vertexBufferBinding->setBinding(1, morph_buffer_);
    vertices_.vertexCount = budget.vertices;
    box_.setInfinite();
}

Ground::~Ground() = default;

void Ground::upload(const fjell::CutMesh& cut, const fjell::CutChanges& changes) {
    uploaded_ = 0;
    fjell::for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
        staging_.clear();
        for (const fjell::MeshVertex& v : cut.mesh.vertices.subspan(first, count))
            staging_.insert(staging_.end(), {static_cast<float>(v.column), static_cast<float>(v.row), v.height_m});
#ifdef PLANT_FORGET // a test's mistake: half of what was written is not copied
        staging_.resize(staging_.size() / 2);
#endif
        vertex_buffer_->writeData(std::size_t{first} * 12, staging_.size() * 4, staging_.data());
        morph_buffer_->writeData(std::size_t{first} * 16, std::size_t{count} * 16, &cut.morph[first]);
        uploaded_ += std::size_t{count} * 28;
    });
    fjell::for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
        index_buffer_->writeData(std::size_t{first} * 12, std::size_t{count} * 12,
                                 &cut.mesh.indices[std::size_t{3} * first]);
        uploaded_ += std::size_t{count} * 12;
    });
}

void Ground::place(const fjell::CutMesh& cut, fjell::Vec3 scene_origin_m, fjell::Vec3 eye_m) {
    range_count_ = cut.mesh.tiles.size();
    while (ranges_.size() < range_count_) ranges_.emplace_back(*this, &vertices_, index_buffer_);
    for (std::size_t i = 0; i < range_count_; ++i) ranges_[i].set(cut.mesh.tiles[i]);

    const fjell::PackHeader& header = terrain_.header();
    const auto from_origin = [&](double x, double y, double z) {
        return Ogre::Vector3(static_cast<float>(x - scene_origin_m.x), static_cast<float>(y - scene_origin_m.y),
                             static_cast<float>(z - scene_origin_m.z));
    };
    box_.setExtents(from_origin(0, header.min_m, 0),
                    from_origin(terrain_.extent_x_m(), header.max_m, terrain_.extent_z_m()));
    if (mParentNode) mParentNode->needUpdate();

    // Whole columns and rows from the one that is nearest to the eye: exact, however large the terrain is.
    const double dx = terrain_.header().spacing_m[0], dz = terrain_.header().spacing_m[1];
    const double column = std::floor(eye_m.x / dx), row = std::floor(eye_m.z / dz);
    const auto eye_height = static_cast<float>(eye_m.y);
    const fjell::Vec3 eye_in_scene = eye_m - scene_origin_m;
    const auto set = [](Ogre::Pass& pass, const std::string& name, std::initializer_list<float> values) {
        const auto& parameters = pass.getVertexProgramParameters();
        if (parameters->_findNamedConstantDefinition(name))
            parameters->setNamedConstant(name, values.begin(), values.size() / 4, 4);
    };
    const fjell::MorphFrame& frame = cut.frame;
    const bool morphs = frame.morph != fjell::Morph::none && frame.views == 1;
    const fjell::MorphView& m = frame.view[0];
    const auto set_pass = [&](Ogre::Pass& pass) {
        set(pass, "eye_cell", {static_cast<float>(column), static_cast<float>(row), 0, 0});
        set(pass, "eye_in_cell_m",
            {static_cast<float>(eye_m.x - column * dx), static_cast<float>(eye_m.z - row * dz), eye_height,
             static_cast<float>(eye_m.y - static_cast<double>(eye_height))});
        set(pass, "spacing_m", {static_cast<float>(dx), static_cast<float>(dz), morphs ? 1.0f : 0.0f, 0});
        set(pass, "eye_in_scene_m",
            {static_cast<float>(eye_in_scene.x), static_cast<float>(eye_in_scene.y), static_cast<float>(eye_in_scene.z),
             0});
        set(pass, "morph_eye_m",
            {static_cast<float>(m.eye_x - eye_m.x), static_cast<float>(m.eye_y - eye_m.y),
             static_cast<float>(m.eye_z - eye_m.z), 0});
        set(pass, "morph", {m.start_per_error, m.full_per_error, frame.now_s, frame.morph_s});
    };
    for (Ogre::Technique* technique : material_->getTechniques()) {
        set_pass(*technique->getPass(0));
        if (const auto& caster = technique->getShadowCasterMaterial()) set_pass(*caster->getTechnique(0)->getPass(0));
    }
}

const Ogre::String& Ground::getMovableType() const {
    static const Ogre::String type = "FjellGround";
    return type;
}

void Ground::_updateRenderQueue(Ogre::RenderQueue* queue) {
    for (std::size_t i = 0; i < range_count_; ++i) queue->addRenderable(&ranges_[i], mRenderQueueID);
}

void Ground::visitRenderables(Ogre::Renderable::Visitor* visitor, bool) {
    for (std::size_t i = 0; i < range_count_; ++i) visitor->visit(&ranges_[i], 0, false);
}

} // namespace host
