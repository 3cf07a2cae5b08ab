"""Which object is being computed: one at a time, the others wait in a queue.

A job has three steps. *Prepare* asks the object for a command line, *compute* is the run of the outside
program, during which FreeCAD stays usable, and *update* first reads all that came back and then changes the
object in one transaction, so that a run that fails leaves the document as it was.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator

from . import door, environment, texts
from .cli import Progress
from .errors import CancelledError, GombocCadError
from .process import Ended, Run

NEW, WAITING, RUNNING, DONE, FAILED, CANCELLED = "new", "queued", "running", "done", "failed", "cancelled"
"""States of a job and of an object."""

Listener = Callable[["Job"], None]


class Job:
    """The computation of one object.

    Attributes:
        title: What a user sees.
        state: One of the states above.
        progress: The stage that runs.
        lines: What the program printed on stderr.
        message: Why it failed.
        superseded: Its object was changed or is gone, so that nobody wants the answer any more.
    """

    def __init__(self, document_object: Any) -> None:
        self.title: str = document_object.Label
        self.object_name: str = document_object.Name
        self.document_name: str = document_object.Document.Name
        self.state = WAITING
        self.progress: Progress | None = None
        self.lines: list[str] = []
        self.message = ""
        self.inputs = ""
        self.superseded = False
        self.folder: Path | None = None
        self.run: Run | None = None

    def is_about(self, document_object: Any) -> bool:
        """Whether it computes this object."""
        return (self.document_name, self.object_name) == (
            document_object.Document.Name,
            document_object.Name,
        )

    def target(self) -> Any:
        """The object; None if it or its document is gone."""
        document = door.App.listDocuments().get(self.document_name)
        return None if document is None else document.getObject(self.object_name)


class Queue:
    """The jobs of this FreeCAD.

    Attributes:
        running: The job whose program runs.
        waiting: The jobs after it.
    """

    def __init__(self) -> None:
        self.running: Job | None = None
        self.waiting: list[Job] = []
        self._listeners: list[Listener] = []
        self._watch: _Watch | None = None

    def subscribe(self, listener: Listener) -> None:
        """Have a function called with a job whenever its state, progress or lines change."""
        self._listeners.append(listener)

    def unsubscribe(self, listener: Listener) -> None:
        """Stop calling a function."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def request(self, document_object: Any) -> Job:
        """Compute an object beside FreeCAD, now or when the jobs before it are done.

        A job of the same object that runs for older values is stopped.
        """
        for waiting in self.waiting:
            if waiting.is_about(document_object):
                return waiting
        self._watch_documents()
        job = Job(document_object)
        self.waiting.append(job)
        self._tell(job, WAITING)
        if self.running is None:
            self._start_next()
        elif self.running.is_about(document_object):
            self._supersede(self.running)
        else:
            door.say(texts.tr(texts.QUEUED, title=job.title, running=self.running.title))
        return job

    def compute(self, document_object: Any) -> None:
        """Compute an object and wait for it.

        Raises:
            GombocCadError: If that failed; the object keeps what it had.
        """
        job = self.request(document_object)
        while job.state in (WAITING, RUNNING):
            if self.running is not None and self.running.run is not None:
                self.running.run.wait()
        if job.state == CANCELLED:
            raise CancelledError(job.message)
        if job.state == FAILED:
            raise GombocCadError(job.message)

    def wait(self, document_object: Any = None, timeout_s: float | None = None) -> None:
        """Wait until an object, or everything, is computed; windows stay alive meanwhile.

        Raises:
            GombocCadError: If time ran out; the jobs go on.
        """
        begin = time.monotonic()
        while any(document_object is None or job.is_about(document_object) for job in self.jobs()):
            if self.running is not None and self.running.run is not None:
                self.running.run.poll()
            if timeout_s is not None and time.monotonic() - begin > timeout_s:
                raise GombocCadError(texts.tr(texts.WAITED_TOO_LONG, seconds=timeout_s))

    def jobs(self) -> list[Job]:
        """The running job and those that wait."""
        return ([self.running] if self.running is not None else []) + self.waiting

    def cancel(self, document_object: Any = None) -> None:
        """Stop the job of an object, or all."""
        for job in [job for job in self.jobs() if document_object is None or job.is_about(document_object)]:
            self._stop(job)

    def withdraw(self, document_object: Any) -> None:
        """An object has what its inputs ask for: what runs or failed for other inputs counts no more."""
        for job in self.jobs():
            if job.is_about(document_object):
                self._supersede(job)
        if document_object.Status != DONE:
            document_object.Status, document_object.Message = DONE, ""
            door.refresh_view(document_object)

    def drop(self, document_name: str, object_name: str | None = None) -> None:
        """Stop the jobs of a document or object that goes away, and say nothing of them."""
        for job in self.jobs():
            if job.document_name == document_name and object_name in (None, job.object_name):
                self._supersede(job)

    def _supersede(self, job: Job) -> None:
        job.superseded = True
        if job in self.waiting:
            self.waiting.remove(job)
            self._tell(job, CANCELLED)
        elif job.run is not None:
            job.run.cancel()

    def _stop(self, job: Job) -> None:
        if job in self.waiting:
            self.waiting.remove(job)
            self._fail(job, CANCELLED, texts.tr(texts.CANCELLED, title=job.title))
        elif job.run is not None:
            job.run.cancel()

    def _start_next(self) -> None:
        while self.running is None and self.waiting:
            job = self.running = self.waiting.pop(0)
            try:
                self._start(job)
            except Exception as error:
                # Whatever broke, the next one has its turn.
                self._end(job)
                self._fail(job, FAILED, str(error))

    def _start(self, job: Job) -> None:
        target = job.target()
        if target is None:
            raise GombocCadError(texts.tr(texts.NOT_BUILT, label=job.title))
        python = environment.ready_python()
        job.folder = Path(tempfile.mkdtemp(prefix="gomboc-"))
        job.inputs = target.Proxy.inputs(target)
        arguments = target.Proxy.prepare(target, job.folder)
        job.run = Run(
            python, arguments, lambda lines: self._lines(job, lines), lambda ended: self._ended(job, ended)
        )
        job.run.start()
        self._tell(job, RUNNING)

    def _lines(self, job: Job, lines: list[str]) -> None:
        assert job.run is not None
        job.lines += lines
        job.progress = job.run.transcript.progress
        self._tell(job, job.state)

    def _ended(self, job: Job, ended: Ended) -> None:
        target = job.target()
        try:
            if not job.superseded and target is not None:
                _take(target, ended.document(), job)
        except CancelledError:
            self._end(job)
            self._fail(job, CANCELLED, texts.tr(texts.CANCELLED, title=job.title))
        except GombocCadError as error:
            self._end(job)
            self._fail(job, FAILED, str(error))
        else:
            self._end(job)
            self._tell(job, CANCELLED if job.superseded else DONE)
            if not job.superseded and target is not None and not target.Document.Recomputing:
                # What depends on the object, and the object itself if it was changed meanwhile.
                target.Document.recompute([target, *target.InListRecursive])
        self._start_next()

    def _end(self, job: Job) -> None:
        if job.folder is not None:
            shutil.rmtree(job.folder, ignore_errors=True)
        self.running = None

    def _fail(self, job: Job, state: str, message: str) -> None:
        job.message = message
        target = job.target()
        if target is not None:
            target.Message = message
            if not target.Document.Recomputing:
                # So that a recompute tries again, as FreeCAD does with its own features.
                target.touch()
        (door.warn if state == CANCELLED else door.complain)(message)
        self._tell(job, state)

    def _tell(self, job: Job, state: str) -> None:
        job.state = state
        target = None if job.superseded else job.target()
        if target is not None and target.Status != state:
            target.Status = state
            door.refresh_view(target)
        for listener in list(self._listeners):
            listener(job)

    def _watch_documents(self) -> None:
        if self._watch is None:
            self._watch = _Watch(self)
            door.App.addDocumentObserver(self._watch)


class _Watch:
    """Hears from FreeCAD when a document or an object goes away."""

    def __init__(self, queue: Queue) -> None:
        self._queue = queue

    def slotDeletedDocument(self, document: Any) -> None:
        self._queue.drop(document.Name)

    def slotDeletedObject(self, document_object: Any) -> None:
        self._queue.drop(document_object.Document.Name, document_object.Name)


def _take(target: Any, document: dict[str, Any], job: Job) -> None:
    """Have an object take an answer over; whatever is wrong with the answer becomes a sentence."""
    try:
        results = target.Proxy.read(target, document, job.folder)
        _change(target, lambda: target.Proxy.update(target, results, job.inputs))
    except GombocCadError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise GombocCadError(texts.tr(texts.NO_ANSWER, reason=reason)) from error


def _change(target: Any, update: Callable[[], None]) -> None:
    """Change an object in one transaction: wholly, or not at all."""
    document = target.Document
    if document.Recomputing:
        # The recompute belongs to a transaction of the user already.
        update()
        return
    document.openTransaction(target.Label)
    try:
        update()
    except BaseException:
        document.abortTransaction()
        raise
    document.commitTransaction()


queue = Queue()
"""The one queue of this FreeCAD."""

_synchronous = 0


def waits() -> bool:
    """Whether a recompute waits for its computations: without windows it does."""
    return _synchronous > 0 or not door.gui_up()


@contextmanager
def synchronous() -> Iterator[None]:
    """Within this, a recompute waits for its computations although there are windows."""
    global _synchronous
    _synchronous += 1
    try:
        yield
    finally:
        _synchronous -= 1
