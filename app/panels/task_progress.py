"""The progress of a background task, with Cancel: the same in every panel and dialog."""

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.widgets import theme
from lensbench.app.workers.task import Task
from lensbench.kernels.figures import fixed


def task_progress(task: Task, width: float = 0.0) -> None:
    """Draw a bar with the task's description and progress, and a button that cancels it.

    width: of both in pixels; 0 for the rest of the line.
    """
    width = (width or imgui.get_content_region_avail().x) - theme.em(2.4)
    imgui.push_style_color(imgui.Col_.plot_histogram, imgui.ImVec4(*theme.colours().frame_active))
    imgui.progress_bar(task.progress, ImVec2(width, 0.0),
                       f"{task.description}  "
                       f"{fixed(100.0 * task.progress, 0)} %" if task.progress else task.description)
    imgui.pop_style_color()
    imgui.same_line()
    if imgui.button(icons_fontawesome_6.ICON_FA_XMARK + "###Cancel task"):
        task.cancel()
    imgui.set_item_tooltip("Cancel")
