"""Starting and resuming runs."""

from __future__ import annotations

import contextlib
import functools
import math
import os
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume._compiler_events import watch
from ecume._hooks import html_of
from ecume.errors import BadInput, Diverged, Stopped, StorageError
from ecume.models.model import LOCAL, LONGEST_RUN, Engine
from ecume.models.step_counts import BEFORE
from ecume.run import checkpoints, constants, manifest
from ecume.run.checkpoints import Checkpoint
from ecume.run.directory import (
    RunDirectory,
    clear,
    existing,
    identity_of,
    manifest_of,
    read,
    refuse_existing,
    sweep,
    write,
)
from ecume.run.invariant_monitor import POLICIES, Watch, sentence
from ecume.run.lock import PATIENT, StopRequest, held, stop_requests
from ecume.run.progress import Pace, Progress, StatusFile, note
from ecume.run.recording import Recording
from ecume.run.samples import NOTHING, Kept, SampleFile
from ecume.run.selection import require_known, require_numbers, selection_of
from ecume.run.until import UNTIL, awaited, require_awaited
from ecume.run.user_code import NO_CODE, Law, UserCode, require_same, warn_of_uncovered
from ecume.run.verification import ENGINE, IMPORTED, require_computed, require_engine, require_flow_file, require_source
from ecume.trajectories.records import DONE, as_json, clean, identity, scene_at, storing, write_whole
from ecume.trajectories.segments import good_frames, repair, set_foreign_aside

if TYPE_CHECKING:
    from ecume.models.actions import Action
    from ecume.models.model import Model
    from ecume.scenes.schema import Scene
    from ecume.simulation import Moment
    from ecume.trajectories.frame import Frame


CHANGED_BY_ACTIONS = ("momentum",)
"""Invariants that actions may violate by changing velocities: their work is in the energy budget, but their impulse is
not.
"""
OUTCOMES = {Stopped: "stopped", Diverged: "failed"}
"""The recorded outcome of a run by the exception that ended it; any other exception interrupted it."""


class RunResult(NamedTuple):
    """The result of a completed run."""

    directory: Path
    frames: int
    steps: int
    """The number of time steps."""
    time: float
    """The simulated time (s)."""
    seconds: float
    """The wall time (s) of this session; 0 for a run that was complete before."""
    integrating: float | None = None
    """The part of it spent in time steps; the rest is setup, compilation and the first step."""
    until: str = ""
    """The condition that should end the run before its duration, if any."""
    early: bool = False
    """Whether it has ended the run."""

    def _repr_html_(self) -> str | None:
        """The notebook view: the player of `ecume view`, in at most 4 MB."""
        return html_of(self.directory)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run that change no bit of a frame."""

    threads: int | None = None
    """The number of threads; default: the number of cores."""
    progress: Callable[[Progress], None] | None = None
    """Receives the progress of the run several times per second."""
    checkpoint_every: float = 60.0
    """Wall time (s) between checkpoints."""
    source: bytes | None = None
    """The scene file, byte for byte, which is copied into the run."""
    engine: Engine | None = None
    """The engine that integrates instead of the scene's model: see `ecume_lammps.engine`."""
    on_violation: str | None = None
    """The response to a violated invariant, see `invariant_monitor.POLICIES`; default: that of the interrupted run, or
    that of the scene.
    """
    on_frame: Callable[[str, Frame, int], None] | None = None
    """A function that gets the name of the model, each computed frame, and its number of time steps."""
    numbers: Sequence[str] = ()
    """Numbers of frames that `on_frame` needs: unknown ones are refused before the run starts or continues."""
    imported: str = ""
    """The name of the file whose frames the run contains, instead of computed ones: see `ecume.run.imports`."""
    longest: float = LONGEST_RUN
    """The longest accepted wall time (s): a run that is expected to take longer, by the speed of its first steps, is
    refused.
    """
    until: str = ""
    """A condition that ends the run before its duration, see `ecume.run.until`. A resumed run keeps its own."""
    strict: bool = False
    """Whether resuming fails if a frame that is computed again differs in any bit from the one on disk, also on another
    processor or with other versions; otherwise such frames are replaced, with a warning.
    """

    def __post_init__(self) -> None:
        """Raise BadInput for an unknown policy."""
        if self.on_violation not in (None, *POLICIES):
            raise BadInput(f"on_violation: got {self.on_violation!r}; expected one of {', '.join(POLICIES)}")


USUAL = RunOptions()


def run(
    scene: Scene,
    directory: str | os.PathLike[str],
    *,
    extra_laws: Sequence[Law] = (),
    actions: Sequence[Action] = (),
    force: bool = False,
    options: RunOptions = USUAL,
) -> RunResult:
    """Simulate a scene into a new directory, with user laws and actions if there are any, as `simulate` does.

    Raises RunExists if the directory exists (`force` replaces a run, but nothing else), Diverged, StorageError, and
    Stopped after a signal; `resume` then continues from a checkpoint.
    """
    home = RunDirectory(Path(directory))
    refuse_existing(home, force=force)
    code = UserCode(extra_laws, actions)
    with stop_requests(PATIENT) as request:
        moments = _moments(scene, Checkpoint(None, 0), code, options, None)
        first = next(moments)  # a scene that cannot be run is refused before any file is written
        if first.frame is not None:
            require_known(scene, first.frame)
            require_numbers(options.numbers, first.frame)
            require_awaited(options.until, selection_of(scene, _model(scene)).of(first.frame))
        with storing(home.path):
            home.path.mkdir(parents=True, exist_ok=True)
        with held(home):
            refuse_existing(home, force=force)
            clear(home)
            _found(home, scene, first.parameters, code, options)
            session = _Session(home, scene, options, Checkpoint(None, 0), code)
            moments = _beginning_with(first, moments)
            del first  # its frame
            return _drive(session, moments, request)


def resume(
    directory: str | os.PathLike[str],
    *,
    extra_laws: Sequence[Law] = (),
    actions: Sequence[Action] = (),
    options: RunOptions = USUAL,
) -> RunResult:
    """Continue a run that was stopped, killed, or ran out of disk space; for a completed run return
    its result.

    On the same kind of processor and with the same versions the result is the same, bit for bit, as without the stop.
    Elsewhere the last digits may differ; frames that were already written after the last checkpoint are then replaced,
    with a warning that says by how much they differ (`RunOptions.strict` refuses that). A run with a user's laws or
    actions needs the same `extra_laws` and `actions` again: their text and the numbers they use are compared with those
    it was begun with.
    """
    from ecume.scenes.schema import from_plain

    home = existing(directory)
    with stop_requests(PATIENT) as request, held(home):
        if (done := _completed(home)) is not None:
            return done
        require_computed(home)
        require_engine(home, options.engine)
        code = UserCode(extra_laws, actions)
        require_same(home, code)
        require_source(home)
        sweep(home)
        for remark in set_foreign_aside(home.trajectory, identity_of(home)):
            note(home, "segment set aside", why=remark)
        scene = from_plain(scene_at(home.path, manifest_of(home)))
        require_flow_file(home, scene)
        constants.require_sound_constants(home)
        checkpoint = _checkpoint(home, scene)
        restore = functools.partial(_constants, home, strict=options.strict)
        moments = _moments(scene, checkpoint, code, options, restore)
        first = next(moments)
        if first.frame is not None:
            require_numbers(options.numbers, first.frame)
        _reopen(home)
        moments = _beginning_with(first, moments)
        del first  # its frame
        return _drive(_Session(home, scene, options, checkpoint, code), moments, request)


def _beginning_with(first: Moment, rest: Iterator[Moment]) -> Iterator[Moment]:
    """The moments with one before them, which is not kept: frames of many particles are large."""
    yield first
    del first
    yield from rest


def _completed(home: RunDirectory) -> RunResult | None:
    """The result of a complete and undamaged run, otherwise None. A damaged run is resumed, and its damaged parts are
    computed again.
    """
    if not home.done.exists():
        return None
    done = read(home, home.done, DONE)
    expected, found = done.get("sha256", {}), manifest.digests(home)
    damaged = [name for name, digest in expected.items() if found.get(name) != digest]
    if not damaged:
        until = manifest_of(home).get(UNTIL, "")
        return RunResult(
            home.path, done["frames"], done["step"], done["time"], 0.0, None, until, done.get("early", False)
        )
    note(home, "damaged after it was done", files=damaged)
    warnings.warn(f"{home.path}: {', '.join(damaged)}: damaged after the run was done; computed again", stacklevel=1)
    if home.samples.name in damaged and home.samples.exists():  # not in checkpoints of earlier versions
        checkpoints.set_aside(home, home.samples)
    return None


def _reopen(home: RunDirectory) -> None:
    """Remove the markers of a run that ended. They contain its digests, and are needed until the run is accepted for
    resuming.
    """
    for marker in (home.done, home.failed):
        with storing(marker):
            marker.unlink(missing_ok=True)


def _moments(
    scene: Scene,
    checkpoint: Checkpoint,
    code: UserCode,
    options: RunOptions,
    constants: Callable[[Any], Any] | None,
) -> Iterator[Moment]:
    from ecume._jit import use_threads  # imported here, since `ecume info` does not need Numba
    from ecume.simulation import moments

    watch.attach()
    use_threads(options.threads)
    sampled = int(checkpoint.samples["last"][0]) if checkpoint.samples else BEFORE
    return moments(
        scene,
        state=checkpoint.state,
        extra_laws=code.laws,
        actions=code.actions,
        engine=options.engine,
        constants=constants,
        sampled=sampled if scene.output.samples else None,
    )


def _constants(home: RunDirectory, derived: Any, *, strict: bool) -> Any:
    """The parameters of a resumed run: those derived from the scene, with the stored constants of the run."""
    restored = constants.restored(home, derived)
    if restored.remark:
        note(home, "constants", remark=restored.remark)
    if not restored.kept:
        if strict:
            raise StorageError(f"{home.path}: its constants would be {restored.remark}; --strict refuses that")
        warnings.warn(f"{home.path}: its constants are {restored.remark}; last digits may change here", stacklevel=1)
    return restored.parameters


def _model(scene: Scene, engine: Engine | None = None) -> Model:
    from ecume.models import MODELS

    return MODELS[scene.model] if engine is None else engine.model(MODELS[scene.model])


def _found(home: RunDirectory, scene: Scene, parameters: Any, code: UserCode, options: RunOptions) -> None:
    """Write the files of a new run; the manifest is the last one, and completes it."""
    from ecume.scenes.schema import to_plain
    from ecume.scenes.writing import to_toml

    plain = as_json(to_plain(scene))
    source = to_toml(scene).encode() if options.source is None else options.source
    write_whole(home.scene, source, home.path)
    write_whole(home.resolved, plain, home.path)
    entries = (
        manifest.first_manifest(scene, source, plain)
        | {"constants_sha256": constants.save_constants(home, parameters)}
        | code.entries()
        | {"on_violation": options.on_violation or scene.on_violation}
        | ({UNTIL: options.until.strip()} if options.until else {})
        | ({IMPORTED: clean(options.imported)} if options.imported else {})
        | ({ENGINE: options.engine.name} if options.engine is not None and options.engine.name != LOCAL else {})
    )
    warn_of_uncovered(code.entries())
    write(home, home.manifest, entries | {"run": identity(entries)})


def _checkpoint(home: RunDirectory, scene: Scene) -> Checkpoint:
    """The state from which the run continues: the newest good checkpoint, or the initial state of the scene."""

    def refused(path: Path, fault: str) -> None:
        note(home, "checkpoint set aside", name=path.name, why=fault)

    kind = _model(scene).further_state(scene) or _model(scene).state
    kept = checkpoints.newest(home, kind, _frames_on_disk(home), refused)
    return kept or Checkpoint(None, 0)


def _frames_on_disk(home: RunDirectory) -> int:
    """The number of frames before the first missing or damaged one, after reading them all; a trajectory that cannot be
    opened is repaired first.
    """
    try:
        return good_frames(home.trajectory)
    except StorageError:
        for fault in repair(home.trajectory).faults:
            note(home, "trajectory repaired", why=fault)
    return good_frames(home.trajectory)


def _drive(session: _Session, moments: Iterable[Moment], request: StopRequest) -> RunResult:
    """Integrate to the end, and record the outcome."""
    try:
        with stop_requests(request=request), contextlib.closing(session):
            session.follow(moments, request)
        session.succeed()
    except BaseException as error:
        with contextlib.suppress(StorageError):  # this also fails on a full disk
            session.fail(error)
        raise
    at = session.at
    return RunResult(
        session.directory,
        at.frames,
        at.step,
        at.time,
        session.seconds,
        session.integrating,
        session.until,
        session.early,
    )


class _Session:
    """The open files of one process that works on a run."""

    def __init__(
        self, home: RunDirectory, scene: Scene, options: RunOptions, checkpoint: Checkpoint, code: UserCode = NO_CODE
    ) -> None:
        frames = checkpoint.frames
        self._home, self._options, self._code = home, options, code
        selection = selection_of(scene, _model(scene))
        self.until = manifest_of(home).get(UNTIL, "")
        self._selection, self._awaited, self.early = selection, awaited(self.until, home, frames), False
        repeats = options.engine is None or options.engine.repeats
        self._recording = Recording(
            home, frames, kinds=scene.kinds, strict=options.strict, selection=selection, repeats=repeats
        )
        asked = scene.output.samples
        self._samples = (
            None if asked is None else SampleFile(home.samples, asked, checkpoint.samples, identity_of(home))
        )
        self._scene, self._watch = scene, Watch(home, [], POLICIES[0])
        self._pace, self._status = Pace(scene.duration), StatusFile(home)
        self._began = self._saved = time.monotonic()
        self._opened = False
        self.at = Progress(0, None, 0.0, scene.duration, frames, 0.0, 0.0, None)

    @property
    def directory(self) -> Path:
        """The path of the run."""
        return self._home.path

    @property
    def seconds(self) -> float:
        """The wall time of this process for the run."""
        return time.monotonic() - self._began

    @property
    def integrating(self) -> float:
        """The wall time of time steps."""
        return self._pace.integrating

    def follow(self, moments: Iterable[Moment], request: StopRequest) -> None:
        """Integrate to the end, or until a stop is requested."""
        begun = False
        for moment in moments:
            if not begun:
                self._begin(moment)
                begun = True
                if moment.step == 0:  # random positions may have other last digits on another processor
                    self._save(moment, 0)
            before = self._recording.frames
            self._take(moment)
            if (
                moment.ended
                or self.early
                or request
                or time.monotonic() - self._saved >= self._options.checkpoint_every
            ):
                self._save(moment, before)
            if self.early:
                return
            if request and not moment.ended:
                raise Stopped(f"stopped by {request.name} {self.at.place}; to continue: ecume resume {self._home.path}")
            del moment  # its frame, before the next one is made

    def succeed(self) -> None:
        """Mark the run as complete."""
        self._record_outcome("done")
        report = {"reason": "done", "exit_code": 0, **self._reached(), "sha256": manifest.digests(self._home)}
        report |= {"early": True} if self.early else {}
        write(self._home, self._home.done, report)
        self._status.write("done", self.at, last=True)

    def fail(self, error: BaseException) -> None:
        """Record the failure; if it is permanent, in a file."""
        outcome = next((report for kind, report in OUTCOMES.items() if isinstance(error, kind)), "interrupted")
        self._status.write(outcome, self.at, last=True)
        self._record_outcome(outcome, f"{type(error).__name__}: {error}")
        if isinstance(error, Diverged):
            report = {"reason": "diverged", "exit_code": error.exit_code, "message": str(error), **self._reached()}
            write(self._home, self._home.failed, report | {"sha256": manifest.digests(self._home)})

    def close(self) -> None:
        """Close the files."""
        self._recording.close()
        if self._samples is not None:
            self._samples.close()

    def _begin(self, moment: Moment) -> None:
        from ecume._jit import use_threads

        expected = math.ceil(moment.step / moment.parameters.steps_per_frame)
        if self._recording.frames != expected:
            raise StorageError(
                f"{self._home.checkpoints}: damaged: the newest checkpoint is at step {moment.step} and says "
                f"{self._recording.frames} frames; expected {expected}. Remove it to continue from an earlier one"
            )
        policy = self._options.on_violation or manifest_of(self._home).get("on_violation", POLICIES[0])
        model = _model(self._scene, self._options.engine)
        invariants = model.invariants(self._scene, moment.parameters) * (not self._options.imported)
        if self._code.actions:
            invariants = [row for row in invariants if row.name not in CHANGED_BY_ACTIONS]
        self._watch = Watch(self._home, invariants, policy)
        manifest.open_session(self._home, use_threads(self._options.threads), moment.taken, self._recording.on_disk)
        self._opened = True
        if self._options.engine is not None and (facts := self._options.engine.facts()):
            manifest.record(self._home, **facts)
        differences = manifest.changed(manifest_of(self._home))
        note(self._home, "begun" if moment.step == 0 else "resumed", step=moment.taken, changed=differences)

    def _take(self, moment: Moment) -> None:
        if moment.frame is not None:
            self._recording.take(moment.frame, moment.taken)
            self._judge(moment.frame, moment.taken)
            if self._options.on_frame is not None:
                self._options.on_frame(self._scene.model, moment.frame, moment.taken)
            if self._awaited is not None:
                self.early = self._awaited.take(self._selection.of(moment.frame))
        if self._samples is not None:
            self._sample(self._samples, moment)
        self.at = self._pace.progress(moment, self._recording.frames)
        self._status.write("running", self.at)
        if self._options.progress is not None:
            self._options.progress(self.at)
        if self.at.remaining is not None and self.at.remaining > self._options.longest:
            self._refuse_to_wait(self.at.remaining)

    def _refuse_to_wait(self, remaining: float) -> None:
        """Raise BadInput if the run would take longer than the user allows."""
        steps = f"{self.at.steps} steps" if self.at.steps else "its steps"
        raise BadInput(
            f"{self._home.path}: {steps} would take about {remaining / 86400.0:.3g} days by the speed of the first, "
            f"more than {self._options.longest / 86400.0:g} days; `ecume check` states what determines the time step. "
            "Shorten the run, or allow more with --max-days"
        )

    def _sample(self, samples: SampleFile, moment: Moment) -> None:
        """Add a sample that is due; rows become visible to readers at each frame."""
        if moment.sample is not None:
            samples.take(moment.sample, moment.taken, moment.step)
        if moment.ended or self.early:
            samples.end_block(moment.taken)
        if moment.frame is not None:
            samples.show()

    def _sampled(self) -> Kept:
        """The position of the sampling, with all its rows on the disk."""
        if self._samples is None:
            return NOTHING
        self._samples.settle()
        return self._samples.kept()

    def _save(self, moment: Moment, before: int) -> None:
        """Write a checkpoint of this state, with the number of frames before it."""
        self._recording.settle()
        self._watch.keep()
        path = checkpoints.save(self._home, Checkpoint(moment.state, before, moment.taken, self._sampled()))
        self._saved, self._status.last_checkpoint = time.monotonic(), moment.taken
        note(self._home, "checkpoint", name=path.name)

    def _judge(self, frame: Frame, step: int) -> None:
        """Check the invariants; warn of those violated for the first time, or stop the run."""
        try:
            for verdict in self._watch.take(frame.time, frame.numbers, step, frame.units):
                note(self._home, "broken", what=sentence(verdict))
        except Diverged:
            self._watch.keep()
            raise

    def _reached(self) -> dict[str, Any]:
        return {"step": self.at.step, "steps": self.at.steps, "time": self.at.time, "frames": self.at.frames}

    def _record_outcome(self, outcome: str, why: str = "") -> None:
        note(self._home, outcome, step=self.at.step, why=why)
        if self._opened:  # otherwise the last session in the manifest belongs to another process
            manifest.close_session(self._home, outcome, self.at.step, self.seconds)
