"""What a drawn figure shows: texts that are cut or overlap, and the limits of its axes."""

from itertools import combinations

from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text


def visible_texts(figure: Figure) -> list[Text]:
    """Return the drawn texts of a figure that are not empty; the figure is drawn first."""
    figure.canvas.draw()
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]


def cut_texts(figure: Figure) -> list[str]:
    """Return the titles and labels that end outside the figure, by more than a pixel."""
    whole = figure.bbox.padded(1.0)
    boxes = [(text.get_text(), Text.get_window_extent(text)) for text in titles(figure)]
    return [words for words, box in boxes if not (whole.contains(box.x0, box.y0) and whole.contains(box.x1, box.y1))]


def overlapping_texts(figure: Figure) -> list[tuple[str, str]]:
    """Return the pairs of titles, names of events and marked numbers that overlap, without lines to what they name."""
    boxes = [(text.get_text(), Text.get_window_extent(text)) for text in titles(figure)]
    return [(a, b) for (a, box), (b, other) in combinations(boxes, 2) if box.overlaps(other)]


def titles(figure: Figure) -> list[Text]:
    """Return the title of a figure, titles and written texts of its axes, and entries of legends."""
    visible = {*visible_texts(figure)}
    written = [text for axes in figure.axes for text in (*axes.texts, axes._left_title, axes.title)]
    of_figure = [figure._suptitle] if figure._suptitle is not None else []
    entries = [text for legend in figure.findobj(Legend) for text in legend.texts]
    return [text for text in (*of_figure, *written, *entries) if text in visible]
