// The live cut as an object of a scene: it is culled, casts shadows and receives them as any other.
#pragma once

#include <deque>
#include <vector>

#include <OgreHardwareVertexBuffer.h>
#include <OgreMovableObject.h>
#include <OgreRenderOperation.h>
#include <OgreRenderable.h>

#include <fjell/fjell.h>

namespace host {

// Attach it to a node without rotation and scale that stands at the scene's origin. Positions in the scene count from
// a place of the terrain, the scene's origin, that moves with the camera: floats are enough then.
class Ground final : public Ogre::MovableObject {
public:
    // terrain must outlive it. Maps are not drawn: a host that has some needs a material a layer.
    Ground(const fjell::Terrain& terrain, const fjell::CutBudget& budget, Ogre::MaterialPtr material);
    ~Ground() override;

    // Once a frame, after update_cut(): copies what was written since the last call.
    void upload(const fjell::CutMesh& cut, const fjell::CutChanges& changes);
    // Before rendering: where the scene's origin and the eye that morphs are, in metres of the terrain.
    void place(const fjell::CutMesh& cut, fjell::Vec3 scene_origin_m, fjell::Vec3 eye_m);

    [[nodiscard]] std::size_t uploaded_bytes() const { return uploaded_; }

    const Ogre::String& getMovableType() const override;
    const Ogre::AxisAlignedBox& getBoundingBox() const override { return box_; }
    Ogre::Real getBoundingRadius() const override { return box_.getHalfSize().length(); }
    void _updateRenderQueue(Ogre::RenderQueue* queue) override;
    void visitRenderables(Ogre::Renderable::Visitor* visitor, bool) override;

private:
    // A draw range of the cut: all share the buffers.
    class Range final : public Ogre::Renderable {
    public:
        Range(const Ground& ground, Ogre::VertexData* vertices, Ogre::HardwareIndexBufferSharedPtr indices);
        void set(const fjell::TileRange& range) {
            indices_.indexStart = range.first_index;
            indices_.indexCount = range.index_count;
        }
        const Ogre::MaterialPtr& getMaterial() const override { return ground_.material_; }
        bool getCastsShadows() const override { return ground_.getCastShadows(); }
        void getRenderOperation(Ogre::RenderOperation& operation) override;
        void getWorldTransforms(Ogre::Matrix4* to) const override;
        Ogre::Real getSquaredViewDepth(const Ogre::Camera*) const override { return 0; }
        const Ogre::LightList& getLights() const override { return ground_.queryLights(); }

    private:
        const Ground& ground_;
        Ogre::VertexData* vertices_;
        Ogre::IndexData indices_;
    };

    const fjell::Terrain& terrain_;
    const Ogre::MaterialPtr material_;
    Ogre::AxisAlignedBox box_;
    Ogre::VertexData vertices_;
    Ogre::HardwareVertexBufferSharedPtr vertex_buffer_, morph_buffer_;
    Ogre::HardwareIndexBufferSharedPtr index_buffer_;
    std::deque<Range> ranges_; // stay where they are: render queues keep pointers
    std::size_t range_count_ = 0, uploaded_ = 0;
    std::vector<float> staging_;
};

} // namespace host
