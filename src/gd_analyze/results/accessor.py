"""The accessor `gd` of datasets: elements, verdicts, ranking and figures of a decomposition or a ranking.

It is registered when the first dataset is made (`schema.table`). What the methods need is imported by them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import xarray as xr

from gd_analyze.errors import UsageError
from gd_analyze.schema import require_table
from gd_analyze.text import html_of, number, percent

if TYPE_CHECKING:
    import pandas as pd

    from gd_analyze.figures.axes import ElementPlots

# Rows of a notebook's view.
_SHOWN_ROWS = 12


@xr.register_dataset_accessor("gd")  # type: ignore[no-untyped-call]  # xarray states no types
class DatasetAccessor:
    """What a dataset of `decompose` or `rank` says, as `dataset.gd`."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    def __repr__(self) -> str:
        names = (name for name in vars(DatasetAccessor) if not name.startswith("_"))
        return f"{self._kind.capitalize()} of {self._subject}: {', '.join(f'gd.{name}' for name in names)}"

    def _repr_html_(self) -> str:
        """The elements with the largest torques, for a notebook."""
        frame = self.ranking()
        shown = frame.head(_SHOWN_ROWS).reset_index()
        columns = ("element", "verdict", "torque_share", "torque_joint", "consequence")
        rows = [
            [label, verdict, percent(share), str(joint), number(consequence)]
            for label, verdict, share, joint, consequence in shown[[*columns]].itertuples(index=False)
        ]
        headings = ["element", "verdict", "of peak torque", "at joint", "times allowed error"]
        note = f"{len(rows)} of {len(frame)} elements, the largest torque first; gd.ranking() gives all."
        return html_of(self._subject, headings, rows, note)

    def D(self, label: str) -> xr.DataArray:
        """An element of D by effect, such as "D12"; kg m^2 (kg m, kg), shape (time, effect).

        Raises
        ------
        UsageError
            If the dataset is no decomposition, or has no such element.
        """
        return self._element("D", label)

    def h(self, label: str) -> xr.DataArray:
        """An element of h by effect, "h2", N m (N), or its coefficient "h213"; as for `D`."""
        return self._element("h", label)

    def c(self, label: str) -> xr.DataArray:
        """An element of c, "c2", N m (N), shape (time,); as for `D`."""
        return self._element("c", label)

    def verdicts(self) -> xr.DataArray:
        """The verdict on every element at every set point, in words, shape (time, element).

        Raises
        ------
        UsageError
            If the dataset is no decomposition and no result of `dominance_over_time`.
        """
        from gd_analyze.dynamics.dominance_over_time import dominance_over_time, verdicts

        if "needed" in self._dataset:
            return verdicts(self._dataset)
        return verdicts(dominance_over_time(self._decomposition))

    def ranking(self, **options: Any) -> pd.DataFrame:
        """The ranking of elements as a wide table, the largest torque first.

        Parameters
        ----------
        options
            Those of `rank`, for a decomposition.

        Returns
        -------
        pandas.DataFrame
            A row per element; a column per variable of `rank` and, where it has parts, per effect or source:
            "part_peak_translation".

        Raises
        ------
        UsageError
            If the dataset is neither a decomposition nor a ranking, or an option is wrong.
        """
        from gd_analyze.dynamics.dominance import rank
        from gd_analyze.results.rows import frame_of

        if "torque_share" in self._dataset:
            if options:
                message = "a ranking has its options already"
                raise UsageError(message, where="ranking", expected="a dataset of `decompose`")
            ranking = self._dataset
        else:
            ranking = rank(self._decomposition, **options)
        return frame_of(ranking, "element").set_index("element")

    @property
    def plot(self) -> ElementPlots:
        """Figures of elements as lists of matplotlib axes: `plot.inertia()`, and more.

        Raises
        ------
        UsageError
            If the dataset is no decomposition.
        """
        from gd_analyze.dynamics.dominance import rank
        from gd_analyze.figures.axes import ElementPlots
        from gd_analyze.figures.run import Elements

        dataset = self._decomposition
        return ElementPlots(Elements(tables={"decomposition": dataset, "dominance": rank(dataset)}))

    @property
    def _kind(self) -> str:
        kinds = {"inertia": "decomposition", "torque_share": "ranking", "needed": "dominance over time"}
        return next((kind for name, kind in kinds.items() if name in self._dataset), "dataset")

    @property
    def _subject(self) -> str:
        about = self._dataset.attrs
        return f"{about.get('arm', 'an arm')} along {about.get('trajectory', 'a motion')}"

    @property
    def _decomposition(self) -> xr.Dataset:
        require_table(self._dataset, "decomposition", "decompose")
        return self._dataset

    def _element(self, symbol: str, label: str) -> xr.DataArray:
        from gd_analyze.dynamics.dominance import elements

        dataset = self._decomposition
        n, has_coefficients = dataset.sizes["joint"], "christoffel" in dataset
        by_label = {
            element.label: element
            for element in elements(n, christoffel=has_coefficients)
            if element.label.startswith(symbol)
        }
        if not isinstance(label, str) or label not in by_label:
            expected = f"one of {', '.join(by_label)}"
            raise UsageError("there is no such element", where=symbol, expected=expected, found=str(label))
        element = by_label[label]
        array = dataset[element.quantity]
        axes = [str(dim) for dim in array.dims if str(dim).startswith("joint")]
        return array.isel(dict(zip(axes, element.index, strict=True))).rename(label)
