"""What `build` and `body` both say of what they made: verdict, reasons, margin, and how it rests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Sequence

from . import parts, properties
from .computed import vector


@dataclass(frozen=True)
class Judgement:
    """A verdict and what it stands on; a body that has not one rest has no pose, and no margin.

    Attributes:
        verdict: PASS or FAIL.
        reasons: A sentence each.
        s_margin_mm: Of the centre of mass.
        com_mm: Centre of mass in the body's frame.
        pose: How it rests.
    """

    verdict: str
    reasons: Sequence[str]
    s_margin_mm: float
    com_mm: tuple[float, float, float]
    pose: parts.RestingPose | None

    @property
    def passed(self) -> bool:
        """Whether the verdict is PASS."""
        return self.verdict == "PASS"

    @classmethod
    def of_document(cls, document: Mapping[str, Any], com_mm: Sequence[float]) -> Judgement:
        """Read it from an answer; see that all of it is there before anything is changed."""
        com, rest, pose = properties.point("com_mm", com_mm), document["rest"], None
        if rest:
            down = properties.point("direction", rest["direction"])
            pose = parts.RestingPose(com, down, properties.number("height_mm", rest["height_mm"]))
        margin_mm = document["s_margin_mm"]
        reasons = [str(reason) for reason in document["reasons"]]
        return cls(
            str(document["verdict"]),
            reasons,
            0.0 if margin_mm is None else properties.number("s_margin_mm", margin_mm),
            com,
            pose,
        )

    def show(self, owner: Any) -> None:
        """Set the properties of a product or body, and its datums."""
        owner.Verdict, owner.Good, owner.Reasons = self.verdict, self.passed, self.reasons
        owner.SMargin, owner.CentreOfMass = self.s_margin_mm, vector(self.com_mm)
        if self.pose is not None:
            owner.RestDirection = vector(self.pose.down)
            parts.show_rest(owner, self.pose)
