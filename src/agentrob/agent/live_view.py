"""Show a robot live on the forum's pages: its card, camera, pose and shape, and what is recorded of it for replies."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Sequence
from pathlib import Path
from typing import Any

from agentrob.agent.media.camera import Camera
from agentrob.agent.media.geometry import Geometry
from agentrob.agent.media.pose_files import PoseFiles
from agentrob.agent.media.poses import PoseSampler
from agentrob.agent.media.recorder import Recorder, look_of
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.queue.queue import CommandQueue
from agentrob.agent.reporting.activity import AgentActivity
from agentrob.agent.reporting.presence import Presence
from agentrob.agent.stop.owner import OwnerActions
from agentrob.config.robots import RobotConfig
from agentrob.forums.protocol import Forum, PosePages, RobotPages
from agentrob.robots.driver.client import DriverClient


class LiveView:
    """One robot's live data on the pages of a forum, and its recorder; on other forums only the recorder.

    `folder` is the robot's own. `sees` are the things that its detector knows, `scheduled` returns what its card says
    of schedules, `room_entry` for whom it waits in its room.
    """

    def __init__(
        self,
        name: str,
        settings: RobotConfig,
        forum: Forum,
        driver: DriverClient,
        folder: Path,
        queue: CommandQueue,
        owner: OwnerActions,
        activity: AgentActivity,
        sees: Collection[str],
        scheduled: Callable[[], dict[str, Any]],
        room_entry: Callable[[], dict[str, Any]],
    ) -> None:
        pages = forum if isinstance(forum, RobotPages) else None
        poses = forum if isinstance(forum, PosePages) else None
        room = RoomMap(name, settings)
        self._queue = queue
        self._live = poses is not None
        self.geometry = Geometry(poses, name, settings.model, settings.map.geometry)
        self.poses = PoseSampler(
            poses, driver, name, room, PoseFiles(folder / "poses"), shaped=lambda: not self.geometry.missing
        )
        self._presence = None if pages is None else Presence(
            pages, driver, name, settings, lambda: queue.posts, owner, activity, room if self._live else None,
            self.geometry, sees, scheduled, room_entry,
        )  # fmt: skip
        self.recorder = _recorder(settings, driver, folder, pages)
        self._camera = self._camera_of(name, settings, pages)

    def _camera_of(self, name: str, settings: RobotConfig, pages: RobotPages | None) -> Camera | None:
        """The camera that the board shows live, which also feeds recordings of the room."""
        if pages is None or not settings.room_camera:
            return None
        seen = self.recorder.see if settings.recording.view in ("auto", "room") else lambda _: None
        return Camera(pages, name, settings.room_camera, lambda: self._queue.moving is not None, seen)

    def tasks(self) -> Sequence[Callable[[], Awaitable[None]]]:
        """The tasks that run as long as the agent serves."""
        shown = (self._presence, self._camera, self.poses if self._live else None)
        return [part.run for part in shown if part is not None]

    def changed(self) -> None:
        """Publish a new card: the queue, the schedules or the parts of a post changed."""
        if self._presence:
            self._presence.changed()
        if self._camera and self._queue.moving and not self.recorder.asks_afterwards:
            self._camera.wake()  # for the recording

    def card_changed(self) -> None:
        if self._presence:
            self._presence.changed()

    def watch_camera(self) -> None:
        """Somebody looks at the live picture."""
        if self._camera:
            self._camera.wake()

    async def watch_poses(self) -> None:
        """Somebody looks at the map or the 3D view: publish the robot's shape, too."""
        self.poses.watch()
        before = self.geometry.name, self.geometry.missing
        await self.geometry.publish()
        if before != (self.geometry.name, self.geometry.missing):
            self.card_changed()


def _recorder(settings: RobotConfig, driver: DriverClient, folder: Path, pages: RobotPages | None) -> Recorder:
    room = pages is not None and settings.room_camera and settings.recording.view == "room"
    return Recorder(folder / "recordings", settings.recording, None if room else look_of(settings, driver))
