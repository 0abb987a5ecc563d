"""The loop document: what a model lacks on measured data, how sure that is, and what to measure next."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field

from hyperfab.documents.base import Document, Part, optional


class Misfit(Part):
    """The size of a residual."""

    rms: float = Field(description="root mean square, in the unit of the data")
    relative_rms: float = Field(description="rms over the root mean square of the measured values")
    nrmse: float = Field(description="rms over the largest measured value")
    nrmse_of_tests: float | None = optional(
        "mean over the tests of each test's rms over its own largest measured value"
    )
    chi2_reduced: float = Field(description="mean square in standard deviations of the noise; 1 is noise")


class Errors(Part):
    """Model against data before and after the effects were added, beside the noise of the data."""

    unit: str
    before: Misfit
    after: Misfit
    noise: Misfit
    delivered: Misfit | None = optional("of the model as it was given, before any constant was refitted")
    tests: int | None = optional("tests that were predicted without taking part")
    source: str | None = optional("how the tests that took no part were chosen")


class NoiseFigures(Part):
    """The noise the data were judged against."""

    sd: float = Field(description="one standard deviation of a reading (root mean square), in the unit of the data")
    unit: str
    source: str
    degrees_of_freedom: float | None = None
    specimen_scatter: float | None = optional("relative standard deviation of the stiffness between specimens")
    contraction_scatter: float | None = optional("the same of how much narrower they become")
    correlation: float | None = optional("between neighbouring readings")
    switching: float | None = optional(
        "what is not known of when heaters switched between readings (root mean square), in the unit of the data"
    )
    assumed_scatter: float | None = optional(
        "scatter of specimens that was taken for what is left, though no two were alike"
    )


class Evidence(Part):
    """Why an effect was added."""

    delta_bic: float = Field(
        description="by how much it lowers BIC, readings counted by their number of independent ones"
    )
    variance_share: float = Field(description="share of what was not noise that it takes")
    held_out_share: float | None = optional("share of the error on tests that took no part that it takes")
    tests_helped: float | None = optional("share of those tests it predicts better")


class AddedEffect(Part):
    """An effect that was found and added."""

    id: str
    title: str
    form: str = Field(description="which of the effect's laws: docs/close-loop-laws.md")
    source: str = Field(description="where the law comes from")
    parameters: dict[str, float]
    parameters_sd: dict[str, float] = Field(default_factory=dict)
    evidence: Evidence
    tentative: bool = Field(
        default=False,
        description="whether something stays unexplained beside it: the best the catalogue has, and no finding; the "
        "extended model marks it so too",
    )


class Candidate(Part):
    """An entry of the catalogue, tried on these data."""

    id: str
    title: str
    visible: bool = Field(description="false where these data could not show it at any size")
    not_sought: str | None = optional("why it was left out: the model has it, or what the data lack")
    score: float = Field(description="how far the residual points at it, in standard deviations")
    delta_bic: float = Field(
        description="what it lowers BIC by: alone, or, where it was added, beside the other added ones"
    )
    strength: Literal["decisive", "strong", "weak", "none"] = Field(
        default="none",
        description="delta_bic in a word: 10 and more, 6 to 10, 2 to 6, less (Kass and Raftery 1995)",
    )
    refitted: bool = Field(
        description="whether delta_bic is of a fit of all constants; else it follows from the score (0: not visible)"
    )
    probability: float | None = optional(
        "that the model lacks it, from what each model leaves; none where nothing was fitted"
    )
    confounded_with: list[str] = Field(default_factory=list)
    shown_by: str = Field(description="the measurement that tells it from its look-alikes")


class Judged(Part):
    """What a model leaves, by the tests of noise."""

    is_noise: bool
    structured: float = Field(description="rms of what is not noise, in standard deviations of the noise")
    p_lack_of_fit: float
    p_autocorrelation: float
    p_greatest_score: float


class Residual(Judged):
    """What is left after the effects were added; ``before`` is what was left without them."""

    before: Judged | None = optional("the same of the model with its own constants refitted, no effect added")
    rides_on: dict[str, float] = Field(
        default_factory=dict, description="share of it that the means over each state variable explain"
    )
    suggestion: str | None = optional("a formula that would take part of it: a hint, never added")
    suggestion_share: float | None = None


class NextMeasurement(Part):
    """The measurement that would tell the rivals apart."""

    text: str
    details: dict[str, Any] = Field(default_factory=dict)
    misfit: float = Field(description="chi-squared by which the loser would then miss, at the present noise")
    decisive: bool
    instead: list[str] = Field(default_factory=list, description="the next best measurements")


class MovedConstant(Part):
    """A constant of a document upstream, in that document's unit."""

    name: str = Field(description="the document, and the key in it; of the model itself the key of its set-up")
    change: float = Field(description="what it would have to change by")
    sd: float = Field(description="how sure that is, with all constants of the chapter free")
    known_sd: float = Field(description="how sure it was taken to be: as stated, else 10 % or what is usual")


class ChapterTried(Part):
    """One document behind the model, its constants together."""

    chapter: str
    document: str | None = optional("relative to this one; absent where it is the model's own set-up")
    probability: float
    off: float = Field(description="standard deviations of what was known of its constants, together")
    error: Errors = Field(description="by the derivatives of the chain: as its documents are, and with these constants")
    constants: list[MovedConstant]
    shown_by: str = Field(description="the measurement that shows this chapter by itself")


class Upstream(Part):
    """Which of the documents behind the model is off, each chapter's constants together."""

    verdict: Literal["chapter", "ambiguous", "as stated", "something else"]
    chapter: str | None = optional("the one that is off, where it is one")
    document: str | None = optional("its document; where several may be, the likeliest one's")
    probability: dict[str, float] = Field(
        description="of each chapter, that all is as stated, and that it is something else"
    )
    error: Errors | None = optional("of the whole chain run anew with the corrected document, beside it as it was")
    written: str | None = optional("the corrected document, relative to this one")
    command: str | None = optional("the command that takes it, from this document's folder")
    then: list[str] = Field(
        default_factory=list, description="the commands that follow, which make the model of what that one makes"
    )
    chapters: list[ChapterTried]
    indistinguishable: list[str] = Field(
        default_factory=list, description="chapters of which one is off, and these data cannot tell which"
    )
    instead_of: list[str] = Field(
        default_factory=list,
        description="effects that are not needed where that document is put right; these data cannot tell which it is",
    )
    left_out: list[str] = Field(default_factory=list, description="what was not looked at")


class LoopDocument(Document):
    """What ``hf close-loop`` found."""

    KIND: ClassVar[str] = "loop"

    domain: Literal["fabric", "contact", "drape", "heat", "press"]
    verdict: Literal["noise", "effect", "ambiguous", "unexplained"]
    summary: list[str] = Field(default_factory=list, description="the finding in words")
    effects: list[AddedEffect] = Field(default_factory=list)
    constants: dict[str, dict[str, float]] = Field(
        default_factory=dict,
        description="the model's own constants: given, refitted, refitted with the effects",
    )
    noise: NoiseFigures
    error: Errors
    contraction: Errors | None = optional(
        "the same of 1 less the transverse stretch, where that was read; ``error`` is of the stresses alone"
    )
    held_out: Errors | None = None
    residual: Residual
    candidates: list[Candidate] = Field(default_factory=list)
    something_else: float | None = optional("probability that what the model lacks is no entry of the catalogue")
    indistinguishable: list[list[str]] = Field(
        default_factory=list,
        description="sets of effects that these data cannot tell apart, the named one first; among them constants "
        "of the model, where one that is further off than is known of it may be all there is, and the clock of a "
        "mold's log",
    )
    next_measurement: NextMeasurement | None = None
    upstream: Upstream | None = optional("with --upstream: the documents behind the model")
    model: str | None = optional("the extended model, relative to this document")
    model_command: str | None = optional("the command that makes the extended model again, from its folder")
    left_out: dict[str, int] = Field(default_factory=dict, description="rows left out, by reason")
    preparation: list[str] = Field(
        default_factory=list, description="how the measured files were read, and what was done to them"
    )
    warnings: list[str] = Field(default_factory=list)
