"""What an agent says on the forum by itself, in both languages (of limits and understanding, `language` speaks)."""

from __future__ import annotations

from agentrob.language import registry
from agentrob.model import Language

_SENTENCES: dict[str, tuple[str, str]] = {
    # ------------------------------------------------------------ states of a command
    "seen": ("Seen.", "已看到。"),
    "queued": ("Queued, place {place}.", "排队中，第 {place} 位。"),
    "held": (
        "Queued: the same account may command me again in {seconds:.0f} s, and then I go on by myself.",
        "排队中：同一账号 {seconds:.0f} 秒后才能再次指挥我，届时自动继续。",
    ),
    "running": ("Step {step} of {steps}: {doing} …", "第 {step} 步，共 {steps} 步：{doing}……"),
    "waits": ("**Waits for approval.**", "**等待批准。**"),
    "waits.plan": ("I understood: {understood}.", "我的理解：{understood}。"),
    "waits.who": (
        "{who} may approve within {wait} of being asked; then it lapses.",
        "{who}可在发帖后 {wait}内批准，过时作废。",
    ),
    "waits.how": (
        "They reply here `@{robot} approve` or `@{robot} deny`.",
        "请在此回复 `@{robot} 批准` 或 `@{robot} 拒绝`。",
    ),
    "waits.own": ("Whoever asked for it may not approve it.", "提出要求的人不能自己批准。"),
    "who.operator": ("Operators", "操作员"),
    "who.moderator": ("Moderators and admins", "版主和管理员"),
    "who.admin": ("Admins", "管理员"),
    "who.owner": ("Its owner and admins", "机器人的主人和管理员"),
    "approved.by": ("Approved by {who}.", "批准者：{who}。"),
    "denied.by": ("{who} denied it.", "{who} 拒绝了这个命令。"),
    "lapsed": (
        "**Expired.** Nobody approved it within {wait}. Post it again if you still want it.",
        "**已过期。** {wait}内没有人批准。如仍需要，请重新发帖。",
    ),
    "done": ("**Done.**", "**完成。**"),
    "failed": ("**Failed** at step {step}.", "**失败**：停在第 {step} 步。"),
    "failed.before": ("**Failed** before anything moved.", "**失败**：还没有任何动作。"),
    "cancelled.at": ("**Cancelled** at step {step}.", "**已取消**：停在第 {step} 步。"),
    "refused.at": ("**Refused** at step {step}.", "**拒绝执行**：停在第 {step} 步。"),
    "goal.done": ("**Finished:** {goal}.", "**结束：** {goal}。"),
    "goal.failed": ("**Not reached:** {goal}.", "**未达成：** {goal}。"),
    "refused": ("**Refused.**", "**拒绝执行。**"),
    "asks_back": ("**I need to ask.**", "**需要确认。**"),
    "stopped": ("**Stopped.**", "**已停下。**"),
    "stopped.by": ("**Stopped** by {who}.", "**已停下**，叫停者：{who}。"),
    "interrupted": (
        "**Interrupted.** I was cut off during this command, stand still, and do not repeat it. "
        "Post it again if you still want it.",
        "**中断。** 执行过程中被打断，我已停住，不会重复执行。如仍需要，请重新发帖。",
    ),
    "interrupted.unknown": (
        "**Interrupted.** My driver stopped answering during this command. I cannot tell whether the robot stands: "
        "look before you come near. I do not repeat the command; post it again if you still want it.",
        "**中断。** 执行过程中驱动没有响应，我无法确认机器人是否已停住：靠近前请先看清。"
        "不会重复执行，如仍需要，请重新发帖。",
    ),
    "interrupted.claim": (
        "**Interrupted.** This post was taken up before, and I cannot tell how far that went, so nothing moves now. "
        "Post it again if you still want it.",
        "**中断。** 这个帖子以前已被受理，我无法确认做到了哪一步，所以现在不动。如仍需要，请重新发帖。",
    ),
    "cancelled": ("**Cancelled.**", "**已取消。**"),
    "expired": (
        "**Expired.** It waited longer than {wait}. Post it again if you still want it.",
        "**已过期。** 等待超过 {wait}。如仍需要，请重新发帖。",
    ),
    "stale": (
        "**Too old.** I act only on posts younger than {seconds:.0f} s that came after I was first started. "
        "Post it again if you still want it.",
        "**太旧了。** 我只执行 {seconds:.0f} 秒以内、并且在我首次启动之后发的帖子。如仍需要，请重新发帖。",
    ),
    "nothing": (
        "I read no command in this post, so I did nothing. Say `help` and I tell you what I can do.",
        "这个帖子里我没有读到命令，所以什么也没做。想知道我会做什么，请说`帮助`。",
    ),
    "see_reply": ("{state} See my reply below.", "{state} 详见下面的回复。"),
    "rule": ("Rule: `{rule}`.", "规则：`{rule}`。"),
    "ask.default": (
        "I did not understand what to do. Try: `walk forward 1 m, turn left 90 degrees, wave`.",
        "我没有看懂要做什么。可以这样写：`向前走 1 米，左转 90 度，挥手`。",
    ),
    # ------------------------------------------------------------ how often one account commands
    "rate.hour": (
        "This account has given me {count} commands within the last hour, and more are not allowed. "
        "Post it again in {minutes} min.",
        "这个账号一小时内已经给我下达了 {count} 个命令，不能再多。请 {minutes} 分钟后重新发帖。",
    ),
    "rate.cooldown": (
        "This account commanded me only a moment ago. Post it again in {minutes} min.",
        "这个账号刚刚指挥过我。请 {minutes} 分钟后重新发帖。",
    ),
    "rate.waiting": (
        "{count} commands of this account wait for me already. Post it again when they are done.",
        "这个账号已有 {count} 个命令在排队。请在它们完成后重新发帖。",
    ),
    "rights.hops": (
        "This command came through more than {count} agents, and I follow no longer chain.",
        "这个命令经过了 {count} 个以上的代理转述，我不执行这么长的转述。",
    ),
    # ------------------------------------------------------------ what approves and does not count
    "approval.nothing": (
        "No command in this thread waits for my approval now.",
        "这个话题里现在没有等待批准的命令。",
    ),
    "approval.which": (
        "I cannot tell which command you mean. Reply to the command itself, or to my answer to it.",
        "我不知道你指的是哪一个命令。请直接回复那个命令，或回复我对它的答复。",
    ),
    "approval.edited": (
        "An edit approves nothing. Write it anew.",
        "修改过的帖子不能用来批准或拒绝。请重新发帖。",
    ),
    "approval.stale": (
        "I came to read this more than {seconds:.0f} s later, so it approves nothing. Approve it again.",
        "我在 {seconds:.0f} 秒之后才读到这个帖子，所以批准无效。请重新批准。",
    ),
    "approval.early": (
        "This was written before I said what I understood, so it approves nothing. Approve it again.",
        "这是在我说明我的理解之前写的，所以批准无效。请重新批准。",
    ),
    "approval.unverified": (
        "I could not check who may approve this, so it changes nothing. Write it again.",
        "无法确认谁可以批准，所以没有生效。请重新发帖。",
    ),
    "approval.lost": (
        "Whoever approved it may not approve it any more.",
        "批准它的账号现在已不能批准。",
    ),
    # ------------------------------------------------------------ why a command was ended before its time
    "because.denied": ("Its approval was denied.", "它没有获得批准。"),
    "because.approval": ("Its approval was taken back.", "对它的批准已被撤回。"),
    "because.stop": ("A stop came.", "收到了停止命令。"),
    "because.edited": (
        "The post was edited, and an edit never starts a motion. Post it anew.",
        "帖子被修改过，修改不会引发动作。请重新发帖。",
    ),
    "because.author": (
        "The post is another account's now, and a command is its author's. Post it anew.",
        "帖子已转到另一个账号名下，而命令只属于它原来的作者。请重新发帖。",
    ),
    "because.removed": ("The post is no longer there.", "帖子已被删除或隐藏。"),
    "because.moved": (
        "Its topic was moved to a board on which I may not be commanded.",
        "主题被移到了不允许指挥我的版块。",
    ),
    "because.taken_back": ("Its author took it back.", "作者撤回了这个命令。"),
    "because.suspended": ("Its author may not command me now.", "作者现在不能指挥我。"),
    "because.unverified": (
        "I could not check whether the command still holds, so I did not go on.",
        "无法确认命令是否仍然有效，所以没有继续。",
    ),
    "because.told": (
        "Another agent of my account has answered this post already.",
        "我的账号的另一个代理程序已经答复过这个帖子。",
    ),
    "because.release": (
        "I was locked when it was posted, and have been released since: nothing of before moves me. Post it anew.",
        "发帖时我处于急停锁定，之后才被解除，此前的命令不再执行。请重新发帖。",
    ),
    "because.clock": (
        "A stop came, and the forum's clock has been set since, so I cannot tell which of the two was first. "
        "Post it again if you still want it.",
        "收到过停止命令，而论坛的时钟此后被调整过，我无法判断先后。如仍需要，请重新发帖。",
    ),
    "because.replaced": (
        "The forum is no longer the one that this was posted on.",
        "论坛已被替换，不再是发帖时的那个论坛。",
    ),
    "because.before": ("It was cancelled before it began.", "在开始之前已被取消。"),
    "because.shutdown": ("My agent was ended.", "我的代理程序被关闭。"),
    "because.driver": ("The robot cannot be used: {message}", "机器人无法使用：{message}"),
    "because.journal": (
        "My journal cannot be written, and without it nothing may move.",
        "日志无法写入；没有日志就不能动作。",
    ),
    "because.not_kept": (
        "My journal could not be written after that, so only this reply tells what came of it.",
        "此后日志无法写入，结果只记录在这条回复里。",
    ),
    "because.internal": ("Something went wrong inside my agent; it is in its log.", "代理程序内部出错，详见其日志。"),
    # ------------------------------------------------------------ a clock that was set
    "clock.back": ("The forum's clock was just set back by {by}.", "论坛的时钟刚被调慢了 {by}。"),
    "clock.ahead": ("The forum's clock was just set ahead by {by}.", "论坛的时钟刚被调快了 {by}。"),
    # ------------------------------------------------------------ steps
    "do.move": ("walk {direction} {distance_m:g} m", "向{direction}走 {distance_m:g} 米"),
    "do.turn": ("turn {direction} {degrees:g}°", "{direction}转 {degrees:g}°"),
    "do.speed": ("{step} at {speed_mps:g} m/s", "{step}，速度 {speed_mps:g} 米/秒"),
    "do.hello": ("wave", "挥手"),
    "do.heart": ("make a heart", "比心"),
    "do.clap": ("clap", "拍手"),
    "do.shake": ("shake hands", "握手"),
    "do.backflip": ("backflip", "后空翻"),
    "do.sit": ("sit", "坐下"),
    "do.stand": ("stand", "站立"),
    "do.stretch": ("stretch", "伸懒腰"),
    "do.get_front_image": ("take a photo", "拍照"),
    "list.joint": (", ", "，"),
    "direction.forward": ("forward", "前"),
    "direction.backward": ("backward", "后"),
    "direction.left": ("left", "左"),
    "direction.right": ("right", "右"),
    "table.step": ("Step", "步骤"),
    "table.asked": ("Asked", "要求"),
    "table.measured": ("Measured", "实测"),
    "table.outcome": ("Outcome", "结果"),
    "outcome.done": ("done", "完成"),
    "outcome.inaccurate": ("inaccurate", "不准确"),
    "outcome.failed": ("failed", "失败"),
    "outcome.refused": ("refused", "拒绝"),
    "outcome.stopped": ("stopped", "停下"),
    "outcome.interrupted": ("interrupted", "中断"),
    "outcome.unknown": ("unknown", "未知"),
    "outcome.skipped": ("not begun", "未开始"),
    "outcome.animated": ("{outcome} (played, not walked by physics)", "{outcome}（播放动画，非物理仿真）"),
    "unknown": ("unknown", "未知"),
    "unknown.odometry_lost": ("unknown: odometry was lost", "未知：里程计丢失"),
    "unknown.odometry_jump": ("unknown: odometry jumped", "未知：里程计跳变"),
    # ------------------------------------------------------------ why a step ended
    "reason.obstacle": ("Something was in the way.", "前方有障碍物。"),
    "reason.fence": ("It would have left the allowed area.", "会走出允许的区域。"),
    "reason.deadline": ("It took too long.", "超时。"),
    "reason.stale_state": ("The robot's state was too old to trust.", "机器人状态太旧，不可信。"),
    "reason.lease_lapsed": ("The driver did not hear from me in time.", "驱动没有及时收到我的信号。"),
    "reason.stop": ("A stop came.", "收到了停止命令。"),
    "reason.halt": ("An emergency stop came; only the owner can release it.", "收到了急停，只有主人能解除。"),
    "reason.halted": (
        "I am halted; only my owner can release that.",
        "我处于急停状态，只有主人能解除。",
    ),
    "reason.stalled": ("I got commands but did not move.", "收到了指令，但没有移动。"),
    "reason.unsupported": ("This robot cannot do that.", "这台机器人做不到。"),
    "reason.busy": ("Somebody else uses the robot.", "机器人正被别人使用。"),
    "reason.not_homed": (
        "My home is not set, so I cannot tell where I may go.",
        "还没有设置原点，无法判断可以去哪里。",
    ),
    "reason.odometry_jump": ("My odometry jumped; I must be homed again.", "里程计跳变，需要重新设置原点。"),
    "reason.ranges_unknown": ("I cannot tell what is around me.", "无法判断周围有什么。"),
    "reason.fallen": (
        "I have fallen, and stay down until I am asked to stand up.",
        "我摔倒了，有人叫我站起来之前不会动。",
    ),
    "reason.low_battery": ("My battery is too low for any motion; charge me.", "电量过低，不能动作，请给我充电。"),
    "reason.posture": (
        "I cannot do that from the posture I am in; somebody must make me stand first.",
        "我现在的姿势做不了，需要先有人让我站好。",
    ),
    "reason.bad_image": ("There is nothing to be seen on my picture.", "我拍的照片上什么也看不到。"),
    "reason.no_answer": ("The robot did not answer.", "机器人没有应答。"),
    "reason.robot_error": ("The robot answered with an error.", "机器人报告出错。"),
    "reason.timeout": ("It took too long.", "超时。"),
    "reason.consent": ("That needs my owner's consent.", "这需要主人同意。"),
    "reason.mandate": ("It would exceed what was allowed for this command.", "超出了这个命令允许的范围。"),
    "reason.stop_channel": (
        "The forum was silent, so nobody could have stopped me.",
        "论坛没有响应，没有人能叫停我。",
    ),
    "reason.shutdown": ("My agent was ended.", "我的代理程序被关闭。"),
    "reason.internal": (
        "Something went wrong inside my agent, so it ended the step.",
        "代理程序内部出错，已结束这一步。",
    ),
    "reason.unreachable": ("The driver stopped answering.", "驱动没有响应。"),
    "reason.other": ("Reason: `{reason}`.", "原因：`{reason}`。"),
    # ------------------------------------------------------------ what stands below
    "note": ("Assumed: {notes}", "按此理解：{notes}"),
    "pictures": ("Pictures: {pictures}.", "图片：{pictures}。"),
    "picture.step": ("photo of step {step}", "第 {step} 步的照片"),
    "picture.path": ("the path measured", "实测路径"),
    "picture.recording": ("a recording", "录像"),
    "picture.data": ("its data", "录制数据"),
    "picture.calls": ("all calls of the model", "模型的全部调用"),
    "pictures.until": (
        "Whoever has a link can open it for {valid}; then it is void.",
        "链接在 {valid}内有效，持有者均可打开。",
    ),
    "slower": (
        "Step {step} was commanded at most {commanded_mps:g} m/s, slower than the {asked_mps:g} m/s asked for.",
        "第 {step} 步实际最高只下达了 {commanded_mps:g} 米/秒，低于要求的 {asked_mps:g} 米/秒。",
    ),
    "timing.seen": ("seen after {seconds:.2f} s", "{seconds:.2f} 秒后看到"),
    "timing.first_motion": ("first motion after {seconds:.2f} s", "{seconds:.2f} 秒后开始动作"),
    "timing.done": ("done after {seconds:.1f} s", "{seconds:.1f} 秒后完成"),
    "trace": ("trace `{trace_id}`", "追踪号 `{trace_id}`"),
    # ------------------------------------------------------------ which mind read it, and what that took
    "mind.rules": ("my rules", "我的规则"),
    "mind.fallback": (
        "{asked} did not read this post ({why}); {by} did.",
        "{asked} 没有读这个帖子（{why}），由{by}代读。",
    ),
    "mind.unscreened": (
        "No model has looked at this command ({why}); my rules found nothing against it.",
        "没有模型检查过这个命令（{why}）；我的规则没有发现问题。",
    ),
    "mind.polished": (
        "{text} (In the words of {mind}; the figures are below.)",
        "{text}（由 {mind} 撰写，数据见下。）",
    ),
    "mind.why.no_key": ("its key is missing", "缺少密钥"),
    "mind.why.no_library": ("its library is not installed", "未安装所需的库"),
    "mind.why.denied": ("its key was refused", "密钥被拒绝"),
    "mind.why.not_found": ("it is not known there", "那里没有这个模型"),
    "mind.why.rejected": ("it rejected the question", "它拒绝了这个请求"),
    "mind.why.limited": ("it takes no more questions for now", "它暂时不接受更多请求"),
    "mind.why.server": ("its server failed", "它的服务器出错"),
    "mind.why.dns": ("its host is not found", "找不到它的主机"),
    "mind.why.tls": ("its connection is not trusted", "连接不可信"),
    "mind.why.unreachable": ("it cannot be reached", "无法连接"),
    "mind.why.broken": ("its answer broke off", "回答中断"),
    "mind.why.timeout": ("no answer in time", "没有及时回答"),
    "mind.why.too_big": ("its answer was too long", "回答过长"),
    "mind.why.malformed": ("its answer was of no use", "回答无法使用"),
    "mind.why.budget": ("its limit of tokens or money is reached", "已达到用量或费用上限"),
    "mind.why.failed": ("it failed", "它出错了"),
    "mind.why.rate": ("your account has reached its limit", "你的账号已达到限额"),
    "usage.line": ("{name}: {parts}", "{name}：{parts}"),
    "usage.joint": (", ", "，"),
    "usage.questions": ("{count} questions", "{count} 次提问"),
    "usage.tokens": ("{input} + {output} tokens", "{input} + {output} 个 token"),
    "usage.unknown": ("tokens unknown", "token 数未知"),
    "usage.time": ("{seconds:.2f} s", "{seconds:.2f} 秒"),
    "usage.failed": ("no answer after {seconds:.2f} s", "{seconds:.2f} 秒后没有回答"),
    # ------------------------------------------------------------ stop
    "stop.taken": (
        "I took this as a stop: while I move or a command waits, I stop when in doubt.",
        "我把这句话当作停止命令：移动中或有命令等待时，拿不准我就停下。",
    ),
    "stop.moving": (
        "Zero velocity was commanded {latency_ms:.0f} ms after the stop",
        "收到停止 {latency_ms:.0f} 毫秒后速度归零",
    ),
    "stop.still": ("I was standing still and stay so", "我本来就没有在动，继续保持不动"),
    "stop.coasted": ("; I came to rest {coasted_m:.2f} m further.", "，又滑行 {coasted_m:.2f} 米后停住。"),
    "stop.end": (".", "。"),
    "stop.unconfirmed": (
        "**I commanded a stop, but the robot did not confirm that it stands.** Use its own stop now.",
        "**已下达停止命令，但机器人没有确认停住。** 请立即使用机器人自带的急停。",
    ),
    "stop.unreachable": (
        "**I could not reach the robot's driver to stop it.** Use its own stop now. The driver stops it by itself "
        "when it no longer hears from me.",
        "**无法联系机器人驱动来停止它。** 请立即使用机器人自带的急停。驱动收不到我的信号时会自行停下。",
    ),
    "stop.halted": (
        "It refuses all motion until its owner releases it.",
        "在主人解除之前，它拒绝一切动作。",
    ),
    "stop.not_halted": (
        "It is **not halted**: its driver could only be told to stop, and a later command may move it.",
        "**没有进入急停**：只能让驱动停住，之后的命令仍可能使它移动。",
    ),
    "stop.cancelled": ("Commands ended or cancelled: {count}.", "结束或取消的命令数：{count}。"),
    "stop.folded": ("Stops since then: {count}.", "此后又收到停止：{count} 次。"),
    "stop.third": (
        "I was stopped {count} times within {minutes} minutes. Somebody should look at what goes on here. {names}",
        "我在 {minutes} 分钟内被叫停了 {count} 次，请有人来看看发生了什么。{names}",
    ),
    # ------------------------------------------------------------ the lock, the home, and how each is dealt with
    "lock.by": ("Locked by {who} {ago} ago: {why}.", "{who} 在 {ago}前将我锁定：{why}。"),
    "lock.nobody": ("Locked: {why}.", "已锁定：{why}。"),
    "lock.emergency": ("an emergency stop", "急停"),
    "owner.named": ("My owner ({owner}) or an admin", "我的主人（{owner}）或管理员"),
    "owner.any": ("My owner or an admin", "我的主人或管理员"),
    "owner.page": ("my page", "我的页面"),
    "how.release": (
        "{who} releases me with the button Release on {page}, or with `agentrob release {robot}` on my machine.",
        "{who}可在{page}上按“Release”解除，或在我的主机上运行 `agentrob release {robot}`。",
    ),
    "how.release.shell": (
        "My owner releases me with `agentrob release {robot}` on my machine.",
        "我的主人可在我的主机上运行 `agentrob release {robot}` 来解除。",
    ),
    "how.home": (
        "{who} sets my home, where I stand, with the button Set home here on {page}, or with `agentrob home {robot}` "
        "on my machine.",
        "{who}可在{page}上按“Set home here”，把我站的地方设为原点，或在我的主机上运行 `agentrob home {robot}`。",
    ),
    "how.home.shell": (
        "My owner sets my home, where I stand, with `agentrob home {robot}` on my machine.",
        "我的主人可在我的主机上运行 `agentrob home {robot}`，把我站的地方设为原点。",
    ),
    # ------------------------------------------------------------ status
    "status.unknown": ("I cannot reach my robot: {message}", "联系不上机器人：{message}"),
    "mode.idle": ("idle", "空闲"),
    "mode.walking": ("walking", "行走中"),
    "mode.gesture": ("in a gesture", "做动作中"),
    "mode.sitting": ("sitting", "坐着"),
    "mode.lying": ("lying", "趴着"),
    "mode.damping": ("damped", "阻尼（已松劲）"),
    "mode.locked": ("locked", "关节锁定"),
    "mode.fallen": ("fallen", "摔倒了"),
    "mode.unknown": ("mode unknown", "状态未知"),
    "status.mode": ("**{mode}**", "**{mode}**"),
    "status.battery": ("battery {percent:.0f} %", "电量 {percent:.0f}%"),
    "status.battery.unknown": ("battery unknown", "电量未知"),
    "status.pose": ("at x {x_m:.2f} m, y {y_m:.2f} m", "位置 x {x_m:.2f} 米，y {y_m:.2f} 米"),
    "status.halted": ("halted until the owner releases it", "急停中，等待主人解除"),
    "status.not_homed": ("home is not set", "未设置原点"),
    "status.queue": ("commands waiting or running: {count}", "排队或执行中的命令：{count}"),
}


def say(key: str, language: Language, **values: object) -> str:
    """The sentence `key` with `values` put in; in a further language as its file says it under `agent.KEY`, else in
    English. An unknown key or a missing value is a `KeyError`."""
    english, chinese = _SENTENCES[key]
    if language == "zh":
        return chinese.format(**values)
    further = registry.known().get(language)
    return (further.sentences.get(f"agent.{key}", english) if further else english).format(**values)


def known(key: str) -> bool:
    return key in _SENTENCES
