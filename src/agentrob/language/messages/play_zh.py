"""What robots say in Chinese of routines, of the way home, and of what they see in their camera."""

from __future__ import annotations

PHRASES = {
    "ask.routine.times": "{words}：一条命令放不下，这里最多{times}次。",
    "ask.routine.square": "{words}：这个大小超出我的限制，这里边长最多{metres}米。",
    "ask.routine.circle": "{words}：这个大小超出我的限制，这里直径最多{metres}米。",
    "ask.routine.circle_radius": "{words}：这个大小超出我的限制，这里半径最多{metres}米。",
    "ask.routine.patrol": "{words}：这个距离超出我的限制，这里单程最多{metres}米。",
    "ask.routine.not_here": "{words}：以我的能力和限制做不了（每条命令{steps}步、{metres}米、{seconds}秒）。",
    "note.routine.dance": "{words}按左右转动和几个动作处理。",
    "note.routine.square": "{words}按{sides}条{side}米的边、每次左转90°处理。",
    "note.routine.circle": "{words}按{sides}条{side}米的边处理，因为我只会直着走、按角度转。",
    "note.routine.patrol": "{words}按往返各{side}米处理，共{times}次。",
}
