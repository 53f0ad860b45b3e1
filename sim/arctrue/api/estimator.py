"""Provides the fit as an estimator that follows scikit-learn's conventions without importing it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Self

from numpy.typing import ArrayLike

from arctrue.api.conditions import Tied
from arctrue.api.fit import fit
from arctrue.api.fit_result import FitResult
from arctrue.api.model import ModelLike
from arctrue.api.sets import SetOrFolder
from arctrue.base.similar import did_you_mean

PARAMETERS = ("model", "fix", "bounds", "tie")


class FitEstimator:
    """An estimator for scikit-learn, whose parameters are the arguments of :func:`arctrue.fit`.

    The parameters are stored as they are given and checked by :meth:`fit`. The name of a result
    ends in ``_``, such as ``result_``.

    Parameters
    ----------
    model : Model, Path, str or iterable of str, optional
        The model, its file, or names of effects to add to the paper's model, which is the default.
    fix : mapping of str to float, or iterable of str, optional
        Parameters that keep a value, in the unit of the parameter.
    bounds : mapping of str to (low, high), optional
        Limits of a parameter, in the unit of the parameter; None on an open side.
    tie : mapping of str to str, (str, float) or callable, optional
        Makes a parameter equal to another parameter, to a multiple of another parameter, or to the
        result of a function of all values.
    """

    def __init__(
        self,
        model: ModelLike = None,
        *,
        fix: Mapping[str, float] | Iterable[str] | None = None,
        bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
        tie: Mapping[str, Tied] | None = None,
    ) -> None:
        """Store the parameters, which are the arguments of :func:`fit`."""
        self.model = model
        self.fix = fix
        self.bounds = bounds
        self.tie = tie

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Give the parameters of the constructor.

        Parameters
        ----------
        deep : bool, optional
            Not used, because no parameter is an estimator.

        Returns
        -------
        dict of str to object
            ``model``, ``fix``, ``bounds`` and ``tie``, as they were given.
        """
        return {name: getattr(self, name) for name in PARAMETERS}

    def set_params(self, **params: Any) -> Self:
        """Change parameters of the constructor.

        Parameters
        ----------
        **params : object
            New values by name.

        Returns
        -------
        FitEstimator
            The same object.

        Raises
        ------
        ValueError
            A name is not the name of a parameter; nothing is changed then.
        """
        for name in params:
            if name not in PARAMETERS:
                raise ValueError(
                    f"{name} is not a parameter.{did_you_mean(name, PARAMETERS)} There are: "
                    f"{', '.join(PARAMETERS)}"
                )
        for name, value in params.items():
            setattr(self, name, value)
        return self

    def fit(self, measurement: SetOrFolder, y: None = None) -> Self:
        """Fit the model to a set; the result is ``result_``.

        Parameters
        ----------
        measurement : MeasurementSet, Path or str
            The set, or the name of its folder.
        y : None, optional
            Not used: the set contains the measured values.

        Returns
        -------
        FitEstimator
            The same object.
        """
        self.result_: FitResult = fit(
            measurement, self.model, fix=self.fix, bounds=self.bounds, tie=self.tie
        )
        return self

    def predict(self, angle: ArrayLike, conditions: Mapping[str, ArrayLike] | None = None) -> Any:
        """Predict the error of head 1, as :meth:`FitResult.predict` does.

        Parameters
        ----------
        angle : array_like, shape (n,)
            Angle of the table, degrees.
        conditions : mapping of str to array_like, shape (n,) or (), optional
            Direction (+1, −1), ``temperature_c`` (°C) and other conditions that the effects need,
            in the units of :meth:`FitResult.predict`.

        Returns
        -------
        ndarray, shape (n,)
            Predicted error, arcseconds.

        Raises
        ------
        ValueError
            Nothing was fitted yet, or an effect needs a condition that is not given.
        """
        if not hasattr(self, "result_"):
            raise ValueError("this FitEstimator is not fitted yet: call fit with a set first")
        return self.result_.predict(angle, conditions)

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn's ``check_is_fitted`` whether :meth:`fit` was called."""
        return hasattr(self, "result_")

    def __sklearn_tags__(self) -> Any:
        """Return the tags of an estimator that is neither classifier nor regressor; only
        scikit-learn calls this method."""
        from sklearn.utils import Tags, TargetTags

        return Tags(estimator_type=None, target_tags=TargetTags(required=False), requires_fit=True)

    def __repr__(self) -> str:
        """Return the constructor call as text, with the parameters that differ from None."""
        given = {name: value for name, value in self.get_params().items() if value is not None}
        return f"FitEstimator({', '.join(f'{name}={value!r}' for name, value in given.items())})"
