package ssv.spy;

import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.ITracePoint2D;
import java.awt.Component;
import java.awt.Container;
import java.awt.Frame;
import java.awt.Rectangle;
import java.awt.Robot;
import java.awt.event.MouseEvent;
import java.io.BufferedReader;
import java.io.File;
import java.io.InputStreamReader;
import java.io.PrintStream;
import java.util.ArrayList;
import java.util.Iterator;
import java.util.List;
import javax.imageio.ImageIO;
import javax.swing.JFrame;
import javax.swing.JTabbedPane;
import javax.swing.JTable;
import javax.swing.SwingUtilities;
import javax.swing.text.JTextComponent;

/**
 * lcm-spy with its window, driven from outside: listens on URL (argument 1), takes commands from standard input and answers each with
 * a line of JSON.
 *   channels         the names in its table
 *   open CHANNEL     double-clicks on it; the titles of the windows that are there then
 *   read CHANNEL     what its window shows: texts, tables, traces of charts, the way from above
 *   picture FILE     the screen
 *   close CHANNEL    closes its window
 */
public final class SpyWindow {
    private static final PrintStream out = System.out;

    private SpyWindow() {
    }

    /** A command with what it prints. */
    private interface Work {
        String run() throws Exception;
    }

    public static void main(String[] args) throws Exception {
        System.setOut(System.err); // where lcm-spy reports
        lcm.spy.Spy.main(new String[] {"--lcm-url", args[0]});
        BufferedReader in = new BufferedReader(new InputStreamReader(System.in));
        for (String line = in.readLine(); line != null; line = in.readLine()) {
            String[] words = line.split(" ", 2);
            out.println(inWindowThread(() -> answer(words[0], words.length > 1 ? words[1] : "")));
            out.flush();
        }
        System.exit(0);
    }

    private static String inWindowThread(Work work) throws Exception {
        String[] answer = {""};
        SwingUtilities.invokeAndWait(() -> {
            try {
                answer[0] = work.run();
            } catch (Exception e) {
                answer[0] = "{\"error\": " + quoted(e.toString()) + "}";
            }
        });
        return answer[0];
    }

    private static String answer(String command, String argument) throws Exception {
        switch (command) {
            case "channels":
                return list(channels());
            case "open":
                doubleClick(channels().indexOf(argument));
                return list(titles());
            case "read":
                return contentOf(window(argument));
            case "close":
                window(argument).dispose();
                return list(titles());
            case "picture":
                Rectangle screen = new Rectangle(java.awt.Toolkit.getDefaultToolkit().getScreenSize());
                ImageIO.write(new Robot().createScreenCapture(screen), "png", new File(argument));
                return "true";
            default:
                throw new IllegalArgumentException(command);
        }
    }

    private static List<String> titles() {
        List<String> titles = new ArrayList<>();
        for (Frame frame : Frame.getFrames()) {
            if (frame.isVisible()) {
                titles.add(frame.getTitle());
            }
        }
        return titles;
    }

    private static JFrame window(String title) {
        for (Frame frame : Frame.getFrames()) {
            if (frame.isVisible() && frame.getTitle().startsWith(title)) {
                return (JFrame) frame;
            }
        }
        throw new IllegalStateException("no window " + title);
    }

    private static JTable table() {
        return all(window("LCM Spy"), JTable.class).get(0);
    }

    private static List<String> channels() {
        List<String> names = new ArrayList<>();
        for (int row = 0; row < table().getRowCount(); row++) {
            names.add(String.valueOf(table().getValueAt(row, 0)));
        }
        return names;
    }

    private static void doubleClick(int row) {
        Rectangle cell = table().getCellRect(row, 0, true);
        for (int count = 1; count <= 2; count++) {
            for (int kind : new int[] {MouseEvent.MOUSE_PRESSED, MouseEvent.MOUSE_RELEASED, MouseEvent.MOUSE_CLICKED}) {
                table().dispatchEvent(new MouseEvent(table(), kind, System.currentTimeMillis(), 0, cell.x + 5, cell.y + 5, count, false,
                    MouseEvent.BUTTON1));
            }
        }
    }

    private static <T> List<T> all(Component within, Class<T> type) {
        List<T> found = new ArrayList<>();
        if (type.isInstance(within)) {
            found.add(type.cast(within));
        }
        if (within instanceof Container) {
            for (Component part : ((Container) within).getComponents()) {
                found.addAll(all(part, type));
            }
        }
        return found;
    }

    private static String contentOf(JFrame frame) {
        List<String> words = new ArrayList<>(), tables = new ArrayList<>(), charts = new ArrayList<>(), ways = new ArrayList<>(), tabs = new ArrayList<>();
        for (JTextComponent text : all(frame, JTextComponent.class)) {
            words.add(quoted(text.getText()));
        }
        for (JTabbedPane pane : all(frame, JTabbedPane.class)) {
            for (int i = 0; i < pane.getTabCount(); i++) {
                tabs.add(quoted(pane.getTitleAt(i)));
            }
        }
        for (JTable table : all(frame, JTable.class)) {
            List<String> rows = new ArrayList<>();
            for (int row = 0; row < table.getRowCount(); row++) {
                List<String> cells = new ArrayList<>();
                for (int column = 0; column < table.getColumnCount(); column++) {
                    cells.add(quoted(String.valueOf(table.getValueAt(row, column))));
                }
                rows.add(cells.toString());
            }
            tables.add(rows.toString());
        }
        for (Chart2D chart : all(frame, Chart2D.class)) {
            chart.getTraces().forEach(trace -> {
                List<String> points = new ArrayList<>();
                for (Iterator<ITracePoint2D> point = trace.iterator(); point.hasNext();) {
                    ITracePoint2D p = point.next();
                    points.add("[" + p.getX() + ", " + p.getY() + "]");
                }
                charts.add("{\"name\": " + quoted(trace.getName()) + ", \"x\": " + quoted(chart.getAxisX().getAxisTitle().getTitle())
                    + ", \"y\": " + quoted(chart.getAxisY().getAxisTitle().getTitle()) + ", \"points\": " + points + "}");
            });
        }
        for (TopView view : all(frame, TopView.class)) {
            view.drawn().forEach(leg -> {
                List<String> points = new ArrayList<>();
                leg.forEach(p -> points.add(java.util.Arrays.toString(p)));
                ways.add(points.toString());
            });
        }
        return "{\"words\": " + words + ", \"tabs\": " + tabs + ", \"tables\": " + tables + ", \"traces\": " + charts + ", \"way\": " + ways + "}";
    }

    private static String list(List<String> texts) {
        List<String> quoted = new ArrayList<>();
        texts.forEach(text -> quoted.add(quoted(text)));
        return quoted.toString();
    }

    private static String quoted(String text) {
        StringBuilder quoted = new StringBuilder("\"");
        for (char c : text.toCharArray()) {
            quoted.append(c < ' ' || c == '"' || c == '\\' ? String.format("\\u%04x", (int) c) : String.valueOf(c));
        }
        return quoted.append('"').toString();
    }
}
