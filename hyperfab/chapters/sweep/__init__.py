"""`hf sweep`: check a study, run its cases, and write the table and what it says."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from types import ModuleType

from hyperfab.cases.sweep import SweepCase
from hyperfab.chapters import steps
from hyperfab.chapters.job import Job
from hyperfab.chapters.sweep.checks import check_study
from hyperfab.chapters.sweep.result import write_result
from hyperfab.console import NEGATIVE_VERDICT, Advance, Terminated
from hyperfab.documents.base import read_document
from hyperfab.documents.study import StudyDocument
from hyperfab.errors import UsageError
from hyperfab.io.output import Output
from hyperfab.numerics.threads import cores
from hyperfab.studies.engine import Engine, Progress
from hyperfab.studies.plan import Plan
from hyperfab.studies.store import Store

#: A study of more cases than this is more often a slip than a wish.
MANY = 1_000_000


def run(job: Job, case: SweepCase, commands: ModuleType = steps) -> int:
    """Run the study; ``commands`` is the module that runs, checks and warms up single commands."""
    study = case.study
    if case.parquet and find_spec("pyarrow") is None:
        raise UsageError("--parquet needs pyarrow: pip install 'hyperfab[parquet]'")
    document = read_document(job.inputs, study, StudyDocument)
    if document.cases > MANY and not case.yes:
        factors = " x ".join(str(axis.count) for axis in document.axis.values() if not axis.drawn)
        drawn = f", {document.sampling.count} samples" if document.sampling is not None else ""
        raise UsageError(
            f"{study}: {document.cases} cases ({factors}{drawn}); more than {MANY} need --yes, or fewer values"
        )
    plan = Plan(document, study, job.inputs)
    check_study(plan, commands)
    store = Store(case.out)
    with store.held():
        output = Output(str(store.folder / "sweep.json"), (".csv", ".parquet", ".effects.png", ".cases.png"))
        output.refuse_inputs(job.inputs)
        engine = _run_cases(job, plan, store, commands, case)
        if isinstance(engine, int):
            return engine
        job.console.note(_account(plan, engine.progress))
        failed, negative = write_result(job, plan, store, engine.accidents, output, case)
    if failed:
        job.console.warn(f"{failed} of {len(plan)} cases failed; the table {output.path('.csv')} says why")
    if negative:
        job.console.note(f"{negative} of {len(plan)} cases have a negative verdict")
    return NEGATIVE_VERDICT if failed or negative else 0


def _run_cases(
    job: Job,
    plan: Plan,
    store: Store,
    commands: ModuleType,
    case: SweepCase,
) -> Engine | int:
    """Run what is not finished; return the engine, or the exit status where the user stopped it."""
    needed = _is_anything_open(plan, store, case.retry_failed)
    try:
        most = len(plan) * len(plan.study.step)
        size = f"{len(plan)} cases, {most} steps at most"
        if needed:
            job.console.note(f"{plan.study.name}: {size}")
        with job.console.progress(plan.study.name, size) as advance:
            tell = _teller(most, advance)
            engine = Engine(
                None,
                store,
                commands.run,
                tell,
                lambda found: case.retry_failed and found.status > 1,
            )
            if not needed:
                engine.run(plan)
                return engine
            from hyperfab.studies import cluster
            from hyperfab.studies.warmth import Warmth

            used = [step.command for step in plan.study.step]
            warmth = Warmth(commands.warm, used, local=case.scheduler is None)
            workers = (
                cluster.remote(case.scheduler, store.folder, warmth)
                if case.scheduler
                else cluster.local(case.jobs or cores(), warmth)
            )
            with workers as client:
                engine.client = client
                engine.run(plan)
                return engine
    except (KeyboardInterrupt, Terminated) as stop:
        job.console.note(
            f"stopped; what is finished is kept in {store.folder}: the same line goes on from there"
        )
        return 130 if isinstance(stop, KeyboardInterrupt) else 143


def _is_anything_open(plan: Plan, store: Store, retry_failed: bool) -> bool:
    """Whether any step is to be run: if not, no worker needs to start."""
    if retry_failed:
        return True
    known: dict[str, bool] = {}
    for case in plan:
        for step in case.steps:
            if step.key not in known:
                outcome = store.outcome(step.key)
                if outcome is None:
                    return True
                known[step.key] = outcome.has_result
            if not known[step.key]:
                break
    return False


def _teller(most: int, advance: Advance) -> Callable[[Progress], None]:
    """Return what the engine calls each second; steps that cases share are seen once, so there are ``most`` at most."""

    def tell(progress: Progress) -> None:
        done = progress.run + progress.reused + progress.skipped
        advance(done / max(most, 1), f"{done} of {most} steps at most")

    return tell


def _account(plan: Plan, progress: Progress) -> str:
    text = f"{len(plan)} cases: {progress.run} steps run, {progress.reused} found finished"
    return text + (f", {progress.skipped} not run for want of an earlier one" if progress.skipped else "")
