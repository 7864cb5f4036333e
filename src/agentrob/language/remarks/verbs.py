"""Verbs with which an order may begin."""

from __future__ import annotations

#: English verbs in their base form.
VERBS = frozenset(
    """
    accept accompany act add address adjust admit adopt advance advise aim alert align allow amplify amuse
    analyse analyze animate announce answer apologise apologize appear applaud apply approach argue arrange
    arrest arrive ask assemble assist attach attack attempt attend avoid babysit back bake balance bang bark
    bathe be beam beat become beg begin behave bend bet beware bite blame blend bless blink block blow boil
    boogie book boop bounce bow box brake break breathe brew bring broadcast browse brush budge build bump burn
    burst bury buy buzz calculate call calm cancel capture care carry carve cast catch celebrate change charge
    chase chat cheat check cheer chew chill chirp choose chop circle clap clean clear climb close coach collect
    color colour comb come comfort command compare complain complete compute concentrate confirm connect
    continue control cook cool copy correct count cover crash crawl create creep cross crouch cruise crush cry
    cuddle curl curtsy cut cycle dance dash deal decide declare decorate defend deliver demonstrate describe
    destroy detect dig dim dip direct disappear discover dismantle display dive divide do dodge donate download
    drag draw dress drift drill drink drive drop dry duck dump dust earn eat echo edit email empty enable end
    enjoy enter entertain erase escape escort estimate evacuate examine exchange exit expand explain explore
    extend extinguish face fall fan fasten feed feel fetch fight file fill film filter find finish fix flap
    flash flatten flee flick flip float flood flush fly focus fold follow forget forgive freeze frighten
    frobnicate frown fry gallop gather get give glance glare glide glow go google grab greet grin grind grip
    groan groove grow
    growl guard guess guide hack hail halt hammer hand handle hang harm harvest haul have head heal hear heat
    heel help hide high highlight hijack hit hold hop hover howl hug hum hunt hurry hush identify ignore imagine
    imitate improve inch increase inform inhale inject insert inspect install introduce invent invite iron jam
    jiggle jog join joke juggle jump keep kick kill kiss kneel knit knock know label land laugh launch lay lead
    lean leap learn leave lend let level lick lie lift light limp line link list listen load lock lollop look
    lose lower lurk mail make march mark massage match measure melt memorise memorize mend message milk mimic
    mind mirror mix moonwalk mop mount mourn move mow mute name nap navigate nod note notice notify nudge obey
    observe offer oil open operate orbit order organise organize overtake own pace pack paint parade park pass patrol
    pause pay peek peel perform phone photograph pick pin pinch pivot place plan plant play plug point poke
    polish pop pose post pounce pour practice practise pray predict prepare present press pretend prevent print
    proceed promise prove provide prune pull pump punch purr push put quack queue quit race raise ramble rap
    reach read rearrange reboot recall recharge recite recognise recommend record recover reduce refill refuse
    relax release remain remember remind remove rename repair repeat replace reply report request rescue reset
    respond rest restart retrieve return reveal reverse review ride ring rinse rise roar roast rock roll rotate
    row rub ruin run rush sabotage salute save saw say scan scare scoot scratch scream scrub search secure seek
    sell send separate serve set sew shadow shake share sharpen shave shift shine shoot shout shove show shower shrug
    shuffle shut shuttle sing sink sit skate skedaddle sketch ski skip slam slap sleep slice slide slip slow
    smash smell smile sneak sneeze sniff snore soak solve somersault soothe sort sound spank speak spell spend
    spill spin spit splash split spray spread sprint spy squash squat squirt squeeze stab stack stand stare start
    startle stay steal steer step stir stop stow straighten stream stretch stroke stroll study stuff sue suggest
    supervise support surprise surround swallow swap sway swear sweep swerve swim swing switch swivel take talk
    tap taste teach tear tease tell terminate test text thank throw tickle tidy tie tighten toot tilt tiptoe toast
    toss touch tour tow trace track trade train transfer translate transport trap travel tread treat trim trip
    trot try tuck tug tumble turn twerk twirl twist type uncover undo unlock unpack unplug unscrew untie update
    upload use vacuum veer visit wag wait wake walk waltz wander warm warn wash watch water wave wear weep weigh
    welcome weld whirl whisk whisper whistle wiggle wink wipe wobble work worry wrap wrestle write yank yawn
    yell yield zap zigzag zip zoom
    """.split()
)
#: Words before the verb of an order: "please just fetch", "could you now fetch".
BEFORE_VERB = frozenset(
    """
    additionally after afterward afterwards again along also always and as besides but by can carefully cool
    could do don't dont even eventually finally fine first followed gently go great hey i immediately instead
    just kindly lastly later let let's lets maybe meanwhile must need never next nice no not now oh ok okay only
    perhaps please pls plus quickly rather right second should simply slowly so still sure thanks that then
    third to too um want well while will with would yeah yes you
    """.split()
)
#: Chinese verbs that seldom begin a statement, as a regular expression.
HAN_VERBS = """(?:其次|首先|其三|完了|然后|接着|最后|第二|之后|随后|紧接着|马上|立刻|顺便|顺带|顺手|快|赶紧|尽量
|随便|故意|偷偷|悄悄|一边|边|再|先|也|就|都|给我|给咱|给咱们|给我们
        |陪我|替我|帮我)*
(?:摸|喂(?![，,！!])|陪|尝|作个|作一|画|揪|拽|换(?:条|个|只|张|首|一)|放(?:首|点|一|段|个|下)|翻(?:个|译|一)|揉
        |腌|熨|缝|修(?:修|好|一)
|替|抄|哄|逗|遛|浇|晒|剥|削|泡|热一|拧|量|称一|查|订|打(?:个|一|开|套|扫|包)|调(?:低|高|小|大|亮|暗|一)|挡住|堵
        |盯|吓|绊|掀|撕|踢|拔|插上|喷|牵|还给
|吹(?:掉|灭|个|一)|敲(?:敲|一|三|两)|耍|猜|吐(?:个|一|出)|守着|守住|解释|回答|导航|保护|冒充|假装|模仿|表演
        |数(?:数|一|到)|点(?:个|一|亮|上)|按|推|拉(?:上|开|一)
|搬|抱|扛|抬|举|捡|扔|擦|扫|拖(?:地|一|干净)|洗|煮|炒|切|盛|倒(?:杯|一|掉|点|垃)|端|递|拿|取|送|寄|发(?:个|一|条
        |给)|写(?:个|一|份|封|首)|读(?:一|给)|念(?:一|给)
|唱|跳(?:个|一|段|支)|扭|蹦|爬|钻|躲|藏|跟(?:着|上|住|紧)|追|赶走|拦|撞|踩|砸|锁|关(?:上|掉|灯|门|窗|一)|开(?:灯
        |门|窗|开|一下)|启动|重启|播|录(?:一|个|段)
|汇报|报告|通知|告诉|提醒|叫(?:醒|住|一)|喊(?:一|他|她|人)|问问|说(?:句|个|一|声)|讲(?:个|一|讲)|闭上|张嘴|张开
        |睁|鞠|敬个|磕|眨|点点头|摇|挥|比(?:个|一)|学(?:个|一|猫|狗|鸡))""".replace("\n", "")
