#include <utility>

#include "editor/command.h"

namespace fjell::editor {

Commands::Commands() {
    list_.reserve(64);
}
Commands::~Commands() = default;
void Commands::clear() {
    list_.clear();
}

void Commands::push(Command command) {
    list_.push_back(std::move(command));
}
template <typename C>
void Commands::push(C command) {
    list_.emplace_back(std::move(command));
}

// One line for each alternative of Command, in its order.
template void Commands::push(OpenFile);
template void Commands::push(OpenSample);
template void Commands::push(SetKey);
template void Commands::push(Undo);
template void Commands::push(Redo);
template void Commands::push(ResetProfile);
template void Commands::push(OpenProfile);
template void Commands::push(SaveProfile);
template void Commands::push(CompareProfile);
template void Commands::push(StopComparing);
template void Commands::push(BrowseFolder);
template void Commands::push(BrowseAllKinds);
template void Commands::push(AnswerUnsaved);
template void Commands::push(RecoverChanges);
template void Commands::push(MoveCamera);
template void Commands::push(PlaceCamera);
template void Commands::push(JumpTo);
template void Commands::push(ViewAll);
template void Commands::push(SetSpeed);
template void Commands::push(SetNavigation);
template void Commands::push(FreezeRefinement);
template void Commands::push(OpenPath);
template void Commands::push(SavePath);
template void Commands::push(RecordPath);
template void Commands::push(PlayPath);
template void Commands::push(SeekPath);
template void Commands::push(AddPoint);
template void Commands::push(ReplacePoint);
template void Commands::push(RemovePoint);
template void Commands::push(SelectPoint);
template void Commands::push(MovePoint);
template void Commands::push(ClearPath);
template void Commands::push(RestorePath);
template void Commands::push(SetPathSeconds);
template void Commands::push(LoopPath);
template void Commands::push(PointProbe);
template void Commands::push(MarkPlace);
template void Commands::push(ClearMarks);
template void Commands::push(SetPictureMode);
template void Commands::push(SetOverlay);
template void Commands::push(ShowPanel);
template void Commands::push(ShowDialog);
template void Commands::push(SetSwitch);
template void Commands::push(ArrangeColumn);
template void Commands::push(FloatPanel);
template void Commands::push(PlacePanel);
template void Commands::push(SetScale);
template void Commands::push(ChooseFrame);
template void Commands::push(HoldMeasures);
template void Commands::push(ZoomGraphs);
template void Commands::push(DismissMessage);
template void Commands::push(DraftBake);
template void Commands::push(GiveBakeFile);
template void Commands::push(OpenBaked);
template void Commands::push(BrowseFor);
template void Commands::push(BakePack);
template void Commands::push(TuneThreshold);
template void Commands::push(RunBenchmark);
template void Commands::push(ExportMesh);
template void Commands::push(PreviewExport);
template void Commands::push(CancelJob);
template void Commands::push(TakeScreenshot);
template void Commands::push(ResizeWindow);
template void Commands::push(DumpState);
template void Commands::push(LoseGraphics);
template void Commands::push(Quit);
template void Commands::push(WaitFrames);
template void Commands::push(WaitSettled);
template void Commands::push(ChoosePlace);
template void Commands::push(ForgetRun);
template void Commands::push(SetHeat);
template void Commands::push(RenderPicture);
template void Commands::push(InsertPoint);
template void Commands::push(PlacePoint);
template void Commands::push(AddBookmark);
template void Commands::push(GoToBookmark);
template void Commands::push(RemoveBookmark);
template void Commands::push(ComparePictures);
template void Commands::push(SetCompareView);
template void Commands::push(SetDivider);

} // namespace fjell::editor
