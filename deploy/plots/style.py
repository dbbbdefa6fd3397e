"""How every figure looks, and how it is written: the same bytes from the same results."""

import io

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from PIL import Image  # noqa: E402

import names  # noqa: E402
import whole_files  # noqa: E402

GREY = "#666666"
_NO_METADATA = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def use():
    plt.rcdefaults()
    plt.rcParams.update({
        "font.size": 10, "axes.titlesize": 11, "axes.labelsize": 10, "legend.fontsize": 10,
        "xtick.labelsize": 9, "ytick.labelsize": 9, "font.family": "DejaVu Sans",
        "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.8,
        "axes.grid": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.6, "axes.axisbelow": True,
        "legend.frameon": False, "lines.solid_capstyle": "round", "figure.dpi": 100,
        "savefig.dpi": 160, "svg.hashsalt": "metronome", "svg.fonttype": "path", "pdf.fonttype": 42,
    })


def grid_of_panels(rows, columns, *, width=3.25, height=2.6, **options):
    """@return (figure, (rows, columns) axes)."""
    extent = (max(width * columns, 5.0), height * rows + 0.6)
    return plt.subplots(rows, columns, figsize=extent, squeeze=False, layout="constrained", **options)


def handle(look, label=None, **options):
    options = {"linewidth": 2.2, "linestyle": look.line, **options}
    return Line2D([], [], color=look.colour, label=label or look.label, **options)


def grey_handle(label, **options):
    """Of what is the same for all arms."""
    return Line2D([], [], color=GREY, label=label, **{"linewidth": 2.2, **options})


def legend(figure, handles, most_columns=5):
    """One for the whole figure, below it, in as many columns as its width allows."""
    for columns in range(min(len(handles), most_columns), 0, -1):
        made = figure.legend(handles=handles, loc="outside lower center", ncols=columns,
                             handlelength=2.2, columnspacing=1.6)
        if columns == 1 or made.get_window_extent().width <= figure.bbox.width:
            return
        made.remove()


def arm_handles(cells, arms):
    return [handle(names.look_of(arm, arms), names.label_of(arm, cells)) for arm in arms]


def millions(axis, end):
    """Labels an axis of steps."""
    axis.set_major_formatter(lambda value, _: f"{value / 1e6:g}")
    axis.axes.set_xlim(0, end)


def thousands(axis):
    """Labels an axis of returns."""
    axis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace("-", "\N{MINUS SIGN}"))


def nothing_yet(ax):
    ax.text(0.5, 0.5, "no finished run has this", transform=ax.transAxes, ha="center", fontsize=8, color=GREY)


def note(ax, text):
    """Small print above the panel's right corner."""
    ax.text(1.0, 1.02, text, transform=ax.transAxes, ha="right", va="bottom", fontsize=8, color=GREY)


def save(figure, path):
    with whole_files.replacing(path) as partial:
        if path.suffix == ".png":
            _save_png(figure, partial)
        else:
            figure.savefig(partial, metadata=_NO_METADATA[path.suffix[1:]])
    plt.close(figure)


def _save_png(figure, path):
    """With 256 colours, which nobody can tell from all and which take a third of the space."""
    full = io.BytesIO()
    figure.savefig(full, format="png")
    full.seek(0)
    with Image.open(full) as image:
        image.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
