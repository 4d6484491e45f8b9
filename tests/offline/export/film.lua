-- A session of one instrument with automation: FILM_FOLDER, FILM_URI; events.txt: port value sample
local folder, uri = os.getenv("FILM_FOLDER"), os.getenv("FILM_URI")
AudioEngine:set_backend("None (Dummy)", "", "")
local s = create_session(folder .. "/session", "film", 48000)
assert(s, "no session")
local info = ARDOUR.LuaAPI.new_plugin_info(uri, ARDOUR.PluginType.LV2)
assert(not info:isnil(), "no plugin")
local audio, midi = ARDOUR.DataType("audio"), ARDOUR.DataType("midi")
local tracks = s:new_midi_track(ARDOUR.ChanCount(midi, 1), ARDOUR.ChanCount(audio, 2), false, info,
  nil, nil, 1, "film", ARDOUR.PresentationInfo.max_order, ARDOUR.TrackMode.Normal, false, false)
for track in tracks:iter() do
  track:panner_shell():set_bypassed(true)
  for n = 0, 1 do
    track:output():audio(n):connect(s:master_out():input():audio(n):name())
  end
  local lists = {}
  for line in io.lines(folder .. "/events.txt") do
    local port, value, sample = line:match("(%d+) (%S+) (%d+)")
    port = tonumber(port)
    if not lists[port] then
      local list, control, _ = ARDOUR.LuaAPI.plugin_automation(track:the_instrument(), port)
      lists[port] = {list, control}
    end
    lists[port][1]:add(Temporal.timepos_t(tonumber(sample)), tonumber(value), false, true)
  end
  local insert = track:the_instrument():to_insert()
  for port, both in pairs(lists) do
    both[1]:set_interpolation(Evoral.InterpolationStyle.Discrete)
    local parameter = Evoral.Parameter(ARDOUR.AutomationType.PluginAutomation, 0, 3 + port)
    insert:to_automatable():automation_control(parameter, false):set_automation_state(ARDOUR.AutoState.Play)
  end
end
s:save_state("")
close_session()
quit()
